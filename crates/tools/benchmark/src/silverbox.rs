//! The Silverbox, an electronic Duffing oscillator [wigren-2013].
//!
//! Its voltages stand for mechanical quantities: 1 V of `V1` is read as 1 N, 1 V of `V2` as 1 m.

use crate::answer::{Answer, Figure, SCHEMA, Test, parameters};
use crate::data::{self, Record};
use crate::drive::Between;
use crate::error::Error;
use crate::place::{Place, Way};
use crate::rivals;
use crate::structure::{Found, Protocol, Stage, Structure, Term, gains, identified};
use friction::effects::EffectKind;
use friction::parameters::OFFSET;
use std::ops::Range;
use std::path::Path;

/// Samples of the record.
pub const SAMPLES: usize = 131_072;
/// Official training span.
pub const TRAIN: Range<usize> = 40_650..105_712;
/// Official tests; the first 50 samples of each set the state.
pub const TESTS: [(&str, Range<usize>); 3] =
    [("multisine", 105_712..127_400), ("arrow", 100..40_575), ("no extrapolation", 100..32_100)];
/// Part of the training span on which structures are compared; they are fitted to what is before it.
pub const HELD_OUT: Range<usize> = 89_447..105_712;

/// The official files, and their column names.
const FILES: &[&str] = &["SNLS80mV.mat", "SNLS80mV.csv"];
const INSIDE: &[&str] = &["silverbox", "SilverboxFiles"];
const MAPS: &[&str] = &["time_s=index/610.35,position_m=V2,force_n=V1"];
const SOURCE: &str = "https://www.nonlinearbenchmark.org/benchmarks/silverbox";

/// One window at the end: the oscillator forgets its state within a few hundred samples.
pub const PROTOCOL: Protocol =
    Protocol { settling: 50, stages: &[Stage::Beginning(3_000), Stage::Beginning(10_000), Stage::Whole] };

/// Structure of the model; the terms were chosen on [`HELD_OUT`].
pub const STRUCTURE: Structure = Structure {
    core: &[Place::Mass, Place::Viscous(Way::Both), Place::Gain(EffectKind::Spring, 0)],
    terms: &[
        Term { name: "cubic spring", places: &[Place::Gain(EffectKind::NonlinearSpring, 0)] },
        Term { name: "quadratic spring", places: &[Place::Gain(EffectKind::NonlinearSpring, 1)] },
        Term {
            name: "quadratic drag",
            places: &[Place::Gain(EffectKind::QuadraticDrag, 0), Place::Gain(EffectKind::QuadraticDrag, 1)],
        },
        Term { name: OFFSET.name, places: &[Place::Gain(EffectKind::Offset, 0)] },
        Term { name: "time skew", places: &[Place::Delay] },
    ],
};

/// Reads the record.
///
/// # Errors
/// A folder without it, or a file of another shape.
pub fn read(dir: &Path) -> Result<Record, Error> {
    let Some(record) = data::read(dir, INSIDE, FILES, MAPS, Between::BandLimited)? else {
        let file = "SNLS80mV.mat or SNLS80mV.csv";
        return Err(Error::Missing { dir: dir.display().to_string(), file, from: SOURCE });
    };
    if record.len() != SAMPLES {
        let why = format!("{} samples; expected are the {SAMPLES} of the official record", record.len());
        return Err(Error::Wrong { file: record.file, why });
    }
    Ok(record)
}

/// Fits the model to the training span.
///
/// # Errors
/// A span that does not determine it.
pub fn train(record: &Record) -> Result<Found, Error> {
    identified(&STRUCTURE.places(), record, &TRAIN, &PROTOCOL)
}

/// Errors of a model on the official tests, mV.
#[must_use]
pub fn test(found: &Found, record: &Record) -> Vec<Test> {
    TESTS
        .iter()
        .map(|(name, span)| Test {
            name,
            error: 1e3 * found.free_run_error(record, span, PROTOCOL.settling),
            unit: "mV",
            samples: span.len() - PROTOCOL.settling,
            official: true,
        })
        .collect()
}

/// The benchmark; `with_gains` refits the model without each of its terms.
///
/// # Errors
/// Those of [`read`] and [`train`].
pub fn run(dir: &Path, with_gains: bool, progress: &(dyn Fn(f32, &str) + Sync)) -> Result<Answer, Error> {
    let record = read(dir)?;
    let gains = if with_gains {
        let pair = [(TRAIN.start..HELD_OUT.start, HELD_OUT)];
        let judge =
            |found: &Found, span: &Range<usize>| 1e3 * found.free_run_error(&record, span, PROTOCOL.settling);
        gains(&STRUCTURE, &record, &pair, &PROTOCOL, &judge, progress)?
    } else {
        Vec::new()
    };
    progress(1.0, "fit to the whole training span");
    let found = train(&record)?;
    Ok(Answer {
        schema: SCHEMA,
        benchmark: "silverbox",
        files: vec![record.file.clone()],
        protocol: vec![
            format!(
                "train {}:{}; each test begins in the state of its first 50 samples, which do not count,",
                TRAIN.start, TRAIN.end
            ),
            "and is driven by the input alone, taken as band-limited between its samples".into(),
        ],
        units: "1 V of V1 is read as 1 N, 1 V of V2 as 1 m",
        parameters: parameters(&found),
        fitted: Figure { name: "training span, free run".into(), value: 1e3 * found.fitted.rms, unit: "mV" },
        converged: found.fitted.converged,
        tests: test(&found, &record),
        force: Vec::new(),
        compared: Vec::new(),
        gains,
        gains_are: format!(
            "free run on {}:{}, fitted to {}:{}, mV",
            HELD_OUT.start, HELD_OUT.end, TRAIN.start, HELD_OUT.start
        ),
        rivals: rivals::SILVERBOX.to_vec(),
        missing: None,
    })
}
