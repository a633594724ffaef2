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
//! use identify::Recording;
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
//! assert_eq!(found.missing[0].effect, "spring");
//! # Ok::<(), diagnose::Error>(())
//! ```
//!
//! `examples/find.rs` does the same with a file, in ten lines. [`diagnose`] is the only entry; [`Diagnosis`] is both the
//! JSON (`tribos.diagnosis/1`) and the series for the report.
#![forbid(unsafe_code)]

mod acting;
mod agreement;
mod ambiguity;
mod channel;
mod design;
mod drift;
mod engine;
mod export;
mod flips;
mod floor;
mod free_run;
mod intake;
mod joint;
mod known_error;
mod linear;
mod lines;
mod locate;
mod nuisance;
mod options;
mod refine;
pub mod report;
mod result;
mod search;
mod sensor;
mod signal;
mod stage;
mod static_branch;
mod term;
mod track;
mod transport;
mod unnamed;
mod validate;
mod wave;
mod witness;
mod words;

pub use design::{ENOUGH, Experiment, Limits, Move, NextExperiment, WORTHWHILE};
pub use engine::diagnose;
pub use nuisance::{Nuisance, PerRecording};
pub use options::{Error, Options};
pub use result::{
    After, Baseline, Bin, Blind, Curve, Diagnosis, Figures, Location, Missing, NoiseFloor, Quantity,
    Rejected, Remainder, SCHEMA, Validation, Verdict,
};

/// Ids of every effect a diagnosis can name, in the order of the catalogue.
#[must_use]
pub fn effect_ids() -> Vec<&'static str> {
    let named: Vec<&str> = term::TermKind::all().iter().map(term::TermKind::id).collect();
    let others = channel::OF_CHANNELS.iter().map(|e| e.0).filter(|id| !named.contains(id));
    named.iter().copied().chain(others).collect()
}
