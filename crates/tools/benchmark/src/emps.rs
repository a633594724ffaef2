//! EMPS, an electro-mechanical positioning system: a motor and a ball screw move a carriage [janot-2019].
//!
//! Open loop the position drifts: it integrates every error of the force, and a tenth of a newton over 25 s is a centimetre. The
//! fit therefore runs over windows of half a second, in which the shape of the friction shows and the drift of an offset
//! does not.

use crate::answer::{Answer, Compared, Figure, Force, SCHEMA, Test, parameters};
use crate::data::{self, Record};
use crate::drive::Between;
use crate::error::Error;
use crate::fit::Fitted;
use crate::place::{Place, Way};
use crate::rivals;
use crate::structure::{Found, Protocol, Stage, Structure, Term, gains, identified};
use friction::effects::EffectKind;
use identify::{Model, Preprocess, prepare};
use std::ops::Range;
use std::path::Path;

const TRAIN_FILE: &[&str] = &["DATA_EMPS.mat"];
const TEST_FILE: &[&str] = &["DATA_EMPS_PULSES.mat"];
const INSIDE: &[&str] = &["emps", "EMPS"];
/// N/V, of the training file [janot-2019]; a file that has it is read with its own.
const MAPS: &[&str] =
    &["time_s=t,position_m=qm,force_n=gtau*vir", "time_s=t,position_m=qm,force_n=35.15065188248547*vir"];
const PUBLISHED_RUN: &str = "janot-2019, run here";
const SOURCE: &str = "https://www.nonlinearbenchmark.org/benchmarks/emps";
/// Shortest record that has two halves with both directions and every speed, samples.
const SHORTEST: usize = 20_000;

/// Length of a window, samples.
pub const WINDOW: usize = 500;
/// How the model is fitted.
pub const PROTOCOL: Protocol = Protocol { settling: 20, stages: &[Stage::Windows(WINDOW)] };

/// Structure of the model; the terms were chosen on halves of the training record. Stribeck friction, sublinear viscous
/// friction and quadratic drag lower the error of the half that is fitted, and not of the other.
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

/// The published model, asymmetric in direction: parameters of [janot-2019].
#[must_use]
pub fn published() -> Found {
    const VALUES: [f64; 5] = [95.154, 20.144, 20.628, 166.71, 240.42];
    Found { places: STRUCTURE.core.to_vec(), fitted: Fitted::given(&VALUES) }
}

/// Root mean square error of the force that the model predicts from the motion of a span, N: against the force as
/// recorded, and both behind the filter of a fit.
///
/// # Errors
/// A span of which no motion can be prepared.
pub fn force_error(found: &Found, record: &Record, span: &Range<usize>) -> Result<[f64; 2], Error> {
    let signals = prepare(&record.part(span), &Preprocess::default())?;
    let mut model = Model::from(&found.plant());
    // a command that is held until the next sample acts half a sample later on average
    model.nuisances.delay_s -= 0.5 * record.drive.dt();
    let predicted = model.predict_signals(&signals);
    let rms = |predicted: &[f64], force: &[f64]| {
        signals::rms(&predicted.iter().zip(force).map(|(p, f)| p - f).collect::<Vec<_>>())
    };
    let filtered = rms(&signals.condition(&predicted), &signals.condition(&signals.force));
    Ok([rms(&predicted, &signals.force), filtered])
}

/// Figures on data that was not fitted.
#[derive(Default)]
struct Judged {
    tests: Vec<Test>,
    force: Vec<Force>,
    /// Of the same fit without the terms, and of the published parameters; mm.
    compared: [Vec<f64>; 2],
}

impl Judged {
    /// Judges a model that was fitted to the span `fitted` of `train` on the span `span` of `record`.
    fn judge(
        &mut self,
        name: &'static str,
        train: &Record,
        fitted: &Range<usize>,
        found: &Found,
        record: &Record,
        span: &Range<usize>,
    ) -> Result<(), Error> {
        let error = |found: &Found| 1e3 * found.free_run_error(record, span, PROTOCOL.settling);
        let five = identified(STRUCTURE.core, train, fitted, &PROTOCOL)?;
        let theirs = published();
        for (model, found, source) in [
            ("this model", found, "run here"),
            ("five parameters, fitted likewise", &five, "run here"),
            ("published five parameters", &theirs, PUBLISHED_RUN),
        ] {
            let [recorded, filtered] = force_error(found, record, span)?;
            self.force.push(Force { name: format!("{model}, {name}"), recorded, filtered, source });
        }
        for (errors, found) in self.compared.iter_mut().zip([&five, &theirs]) {
            errors.push(error(found));
        }
        let samples = span.len() - PROTOCOL.settling;
        let official = !std::ptr::eq(train, record);
        self.tests.push(Test { name, error: error(found), unit: "mm", samples, official });
        Ok(())
    }
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
    let mut files = vec![record.file.clone()];
    let mut judged = Judged::default();
    let missing = if let Some(test) = &test {
        files.push(test.file.clone());
        judged.judge("pulses", &record, &whole, &found, test, &(0..test.len()))?;
        None
    } else {
        for (name, (fitted, other)) in ["second half", "first half"].into_iter().zip(&crossed) {
            judged.judge(name, &record, fitted, &train(&record, fitted)?, &record, other)?;
        }
        let folder = dir.display();
        Some(format!(
            "{} is not in {folder}:\n  each half is fitted and run on the other instead",
            TEST_FILE[0]
        ))
    };
    let [same_fit, theirs] = judged.compared;
    let compared = vec![
        Compared { method: "five parameters, fitted likewise", errors: same_fit, source: "run here" },
        Compared {
            method: if missing.is_some() {
                "published five, fitted to both"
            } else {
                "published five parameters"
            },
            errors: theirs,
            source: PUBLISHED_RUN,
        },
    ];
    Ok(Answer {
        schema: SCHEMA,
        benchmark: "emps",
        files,
        protocol: vec![
            format!(
                "fitted to windows of {WINDOW} samples; the test begins in the state of its first 20 samples, which do"
            ),
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
        tests: judged.tests,
        force: judged.force,
        compared,
        gains,
        gains_are: "free run over the windows of the half not fitted, mm".into(),
        rivals: rivals::EMPS.to_vec(),
        missing,
    })
}
