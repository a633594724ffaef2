//! Finds the physics a simulation left out of a recording: where the mismatch sits, what it is, what else it
//! could be, and how much better the model gets on data it has not seen.
//!
//! The method is sound rather than quick to please: one zero-phase filter on every signal *and* every
//! regressor, the baseline fitted jointly with every candidate, tests by flipping the signs of whole blocks
//! (ordinary t-tests would call one null recording in three a discovery), gains only counted on blocks that
//! were held out, and what the recording cannot tell said as clearly as what it can.
//!
//! ```
//! use diagnose::{Options, Verdict, diagnose};
//! use signals::Recording;
//! let mut hidden = Recording::default();
//! for i in 0..12_000 {
//!     let t = f64::from(i) * 1e-3;
//!     let (x, v, a) = [(0.010, 9.0), (0.006, 23.0)].iter().fold((0.0, 0.0, 0.0), |(x, v, a), (r, w)| {
//!         (x + r * (w * t).sin(), v + r * w * (w * t).cos(), a - r * w * w * (w * t).sin())
//!     });
//!     let noise = 0.05 * (1e4 * t * t).sin();
//!     hidden.time.push(t);
//!     hidden.position.push(x);
//!     hidden.force.push(0.4 * a + 1.5 * v.signum() + 2.0 * v + 60.0 * x + noise); // 60 N/m: not in the model
//! }
//! let found = diagnose(&[hidden], &[], &Options::default(), &|_, _| ())?;
//! assert_eq!(found.verdict, Verdict::Mismatch);
//! assert!(found.missing[0].says.contains("like a spring"));
//! # Ok::<(), diagnose::Error>(())
//! ```
//!
//! `examples/find.rs` does the same with a file, in ten lines. [`diagnose`], or [`diagnose_watched`] which can be interrupted, is the entry, and [`diagnose_planar`] that for two axes; [`Diagnosis`] is both the
//! JSON (`tribos.diagnosis/2`) and the series for the report.
#![forbid(unsafe_code)]

mod experiment;
mod findings;
mod free_form;
mod library;
mod naming;
mod options;
mod per_recording;
mod pipeline;
mod planar;
mod preparation;
mod regression;
mod result;
mod search;

pub use experiment::moves::{Limits, Move};
pub use experiment::proposal::{ENOUGH, Experiment, NextExperiment, WORTHWHILE};
pub use findings::words::{ForceError, summary};
pub use options::{Error, Options};
pub use per_recording::{Nuisance, PerRecording};
pub use pipeline::{diagnose, diagnose_watched};
pub use planar::{PlanarDiagnosis, diagnose_planar, diagnose_planar_watched, planar_effect_ids};
pub use result::{
    After, Baseline, Bin, Blind, CarriesNot, Curve, Diagnosis, Figures, FreeCurve, FreeFormFinding, LeftOut,
    Location, LooksLike, Missing, NoiseFloor, Quantity, Rejected, Remainder, SCHEMA, Validation, Verdict,
};

/// Ids of every effect a diagnosis can name, in the order of the catalogue.
#[must_use]
pub fn effect_ids() -> Vec<&'static str> {
    let named: Vec<&str> = library::term::TermKind::all().iter().map(library::term::TermKind::id).collect();
    let compared = friction::effects::CATALOGUE.iter().filter(|a| a.comparison.is_some()).map(|a| a.id);
    named.iter().copied().chain(compared.filter(|id| !named.contains(id))).collect()
}
