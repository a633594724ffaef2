//! EMPS, an electro-mechanical positioning system: a motor and a ball screw move a carriage [janot-2019].
//!
//! Open loop the position drifts: it integrates every error of the force, and a tenth of a newton over 25 s is a centimetre. The
//! fit therefore runs over windows of half a second, in which the shape of the friction shows and the drift of an offset
//! does not.

use crate::answer::{Answer, Figure, SCHEMA, Test, parameters};
use crate::data::{self, Record};
use crate::drive::Between;
use crate::error::Error;
use crate::place::{Place, Way};
use crate::rivals;
use crate::structure::{Found, Protocol, Stage, Structure, Term, gains, identified};
use friction::effects::EffectKind;
use identify::Model;
use std::ops::Range;
use std::path::Path;

const TRAIN_FILE: &[&str] = &["DATA_EMPS.mat"];
const TEST_FILE: &[&str] = &["DATA_EMPS_PULSES.mat"];
const INSIDE: &[&str] = &["emps", "EMPS"];
/// N/V, of the training file [janot-2019]; a file that has it is read with its own.
const MAPS: &[&str] = &[
    "time_s=t,position_m=qm,force_n=gtau*vir",
    "time_s=t,position_m=qm,force_n=35.15065188248547*vir",
];
const SOURCE: &str = "https://www.nonlinearbenchmark.org/benchmarks/emps";
/// Shortest record that has two halves with both directions and every speed, samples.
const SHORTEST: usize = 20_000;

/// Length of a window, samples.
pub const WINDOW: usize = 500;
/// How the model is fitted.
pub const PROTOCOL: Protocol = Protocol { settling: 20, stages: &[Stage::Windows(WINDOW)] };

/// Structure of the model; the terms were chosen on halves of the training record. Stribeck, sublinear viscous friction,
/// quadratic drag, lag and delay lower the error on the half that is fitted, and not on the other.
pub const STRUCTURE: Structure = Structure {
    core: &[
        Place::Mass,
        Place::Level(Way::Forward),
        Place::Level(Way::Backward),
        Place::Viscous(Way::Forward),
        Place::Viscous(Way::Backward),
    ],
    terms: &[
        Term {
            name: "friction over position, slope",
            places: &[
                Place::Gain(EffectKind::PositionDependentFriction, 0),
                Place::Gain(EffectKind::PositionDependentFriction, 1),
            ],
        },
        Term {
            name: "friction over position, curve",
            places: &[
                Place::Gain(EffectKind::PositionDependentFriction, 2),
                Place::Gain(EffectKind::PositionDependentFriction, 3),
            ],
        },
        Term { name: "force gain asymmetry", places: &[Place::ForceGain] },
    ],
};

/// Reads the training record, and the test record if it is there.
///
/// # Errors
/// A folder without the training record, or a file of another shape.
pub fn read(dir: &Path) -> Result<(Record, Option<Record>), Error> {
    let Some(train) = data::read(dir, INSIDE, TRAIN_FILE, MAPS, Between::Held)? else {
        return Err(Error::Missing { dir: dir.display().to_string(), file: TRAIN_FILE[0], from: SOURCE });
    };
    let test = data::read(dir, INSIDE, TEST_FILE, MAPS, Between::Held)?;
    for record in std::iter::once(&train).chain(&test) {
        if record.len() < SHORTEST {
            let why = format!("{} samples; expected are the 24 841 of the official record", record.len());
            return Err(Error::Wrong { file: record.file.clone(), why });
        }
    }
    Ok((train, test))
}

/// The two halves of a record.
#[must_use]
pub fn halves(record: &Record) -> [Range<usize>; 2] {
    let middle = record.len() / 2;
    [0..middle, middle..record.len()]
}

/// Fits the model to a span of a record.
///
/// # Errors
/// A span that does not determine it.
pub fn train(record: &Record, span: &Range<usize>) -> Result<Found, Error> {
    identified(&STRUCTURE.places(), record, span, &PROTOCOL)
}

/// Root mean square error of the force that the model predicts from the motion of a span, N.
///
/// # Errors
/// A span of which no motion can be prepared.
pub fn force_error(found: &Found, record: &Record, span: &Range<usize>) -> Result<f64, Error> {
    let recording = record.part(span);
    let predicted = Model::from(&found.plant()).predict(&recording)?;
    let errors: Vec<f64> =
        predicted.iter().zip(&recording.force).map(|(p, f)| p - f).filter(|e| e.is_finite()).collect();
    Ok(signals::rms(&errors))
}

/// The benchmark; `with_gains` refits the model without each of its terms.
///
/// # Errors
/// Those of [`read`], [`train`] and [`force_error`].
pub fn run(dir: &Path, with_gains: bool, progress: &(dyn Fn(f32, &str) + Sync)) -> Result<Answer, Error> {
    let (record, test) = read(dir)?;
    let [first, second] = halves(&record);
    let crossed = [(first.clone(), second.clone()), (second, first)];
    let gains = if with_gains {
        let judge = |found: &Found, span: &Range<usize>| {
            1e3 * found.window_error(&record, span, WINDOW, PROTOCOL.settling)
        };
        gains(&STRUCTURE, &record, &crossed, &PROTOCOL, &judge, progress)?
    } else {
        Vec::new()
    };
    progress(1.0, "fit to the whole training record");
    let whole = 0..record.len();
    let found = train(&record, &whole)?;
    let settling = PROTOCOL.settling;
    let figure = |name: &str, value| Figure { name: name.into(), value, unit: "N" };
    let test_of = |name, found: &Found, record: &Record, span: &Range<usize>, official| Test {
        name,
        error: 1e3 * found.free_run_error(record, span, settling),
        unit: "mm",
        samples: span.len() - settling,
        official,
    };
    let (mut tests, mut force) = (Vec::new(), Vec::new());
    let mut files = vec![record.file.clone()];
    let missing = if let Some(test) = &test {
        files.push(test.file.clone());
        let span = 0..test.len();
        tests.push(test_of("pulses", &found, test, &span, true));
        force.push(figure("this model, pulses", force_error(&found, test, &span)?));
        None
    } else {
        for (name, (fitted, judged)) in ["second half", "first half"].into_iter().zip(&crossed) {
            let half = train(&record, fitted)?;
            tests.push(test_of(name, &half, &record, judged, false));
            force.push(figure(&format!("this model, {name}"), force_error(&half, &record, judged)?));
        }
        Some(format!(
            "{} is not in {}: each half is fitted and run on the other instead.",
            TEST_FILE[0],
            dir.display()
        ))
    };
    Ok(Answer {
        schema: SCHEMA,
        benchmark: "emps",
        files,
        protocol: vec![
            format!("fitted to windows of {WINDOW} samples; the test begins in the state of its first 20 samples, which do"),
            "not count, and is driven by the force alone, in open loop, to its end".into(),
        ],
        units: "force = gtau·vir, position = qm",
        parameters: parameters(&found),
        fitted: Figure {
            name: "training record, free run over its windows".into(),
            value: 1e3 * found.fitted.rms,
            unit: "mm",
        },
        converged: found.fitted.converged,
        tests,
        force,
        gains,
        gains_are: "free run over the windows of the half not fitted, mm".into(),
        rivals: rivals::EMPS.to_vec(),
        force_rivals: rivals::EMPS_FORCE.to_vec(),
        missing,
    })
}
