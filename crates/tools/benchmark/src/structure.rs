//! What a model is made of, and what each part of it gains.

use crate::data::Record;
use crate::equation;
use crate::error::Error;
use crate::fit::{Fitted, errors, fit};
use crate::place::Place;
use crate::plant::Plant;
use serde::Serialize;
use std::ops::Range;

/// A part of a model that may be left out.
#[derive(Debug, Clone, Copy)]
pub struct Term {
    /// What it is, for a person.
    pub name: &'static str,
    /// Its parameters.
    pub places: &'static [Place],
}

/// The parameters of a model.
#[derive(Debug, Clone, Copy)]
pub struct Structure {
    /// What every model of the machine has.
    pub core: &'static [Place],
    /// What was found to lower the error on data that was held out.
    pub terms: &'static [Term],
}

/// How a structure is fitted.
#[derive(Debug, Clone)]
pub struct Protocol {
    /// Samples that set the state of a free run; they do not count.
    pub settling: usize,
    /// Lengths of the windows of successive fits, samples; each begins where the one before it ended. A length beyond the
    /// span is the span as one window.
    pub stages: &'static [Stage],
}

/// Windows of one fit.
#[derive(Debug, Clone, Copy)]
pub enum Stage {
    /// One window at the beginning, samples.
    Beginning(usize),
    /// Windows of this length, samples, one behind the other.
    Windows(usize),
    /// The span as one window.
    Whole,
}

impl Stage {
    fn windows(self, span: &Range<usize>) -> Vec<Range<usize>> {
        match self {
            Self::Beginning(samples) => {
                Self::Whole.windows(&(span.start..span.end.min(span.start + samples)))
            }
            Self::Whole => vec![span.clone()],
            Self::Windows(samples) => {
                let samples = samples.clamp(1, span.len().max(1));
                (0..span.len() / samples)
                    .map(|i| span.start + i * samples..span.start + (i + 1) * samples)
                    .collect()
            }
        }
    }
}

/// A fitted model.
#[derive(Debug, Clone)]
pub struct Found {
    /// Parameters, in the order of `fitted.values`.
    pub places: Vec<Place>,
    /// Their values.
    pub fitted: Fitted,
}

/// What a term gains where it was not fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gain {
    /// The term.
    pub term: String,
    /// Error on held-out data of the model without it, in the unit of the report.
    pub without: f64,
    /// Error on the same data of the whole model.
    pub with: f64,
}

impl Structure {
    /// Every parameter.
    #[must_use]
    pub fn places(&self) -> Vec<Place> {
        self.without(None)
    }

    /// Every parameter but those of one term.
    fn without(&self, left_out: Option<usize>) -> Vec<Place> {
        let terms = self.terms.iter().enumerate().filter(|(i, _)| Some(*i) != left_out);
        self.core.iter().copied().chain(terms.flat_map(|(_, t)| t.places.iter().copied())).collect()
    }
}

/// Fits these parameters to a span of a record: equation error, then simulation error.
///
/// # Errors
/// A span that does not determine them.
pub fn identified(
    places: &[Place],
    record: &Record,
    span: &Range<usize>,
    protocol: &Protocol,
) -> Result<Found, Error> {
    let start = equation::start(places, record, span)?;
    let mut values = start.values;
    let mut last = None;
    for stage in protocol.stages {
        let windows = stage.windows(span);
        let fitted = fit(places, &values, &start.scales, record, &windows, protocol.settling);
        values.clone_from(&fitted.values);
        last = Some(fitted);
    }
    match last {
        Some(fitted) if fitted.rms.is_finite() => Ok(Found { places: places.to_vec(), fitted }),
        _ => Err(Error::Unfit {
            file: record.file.clone(),
            why: "no free run stays finite; expected is the official recording".into(),
        }),
    }
}

impl Found {
    /// The model.
    #[must_use]
    pub fn plant(&self) -> Plant<f64> {
        Plant::new(&self.places, &self.fitted.values)
    }

    /// Root mean square error of one free run over a span, m, without the samples that set the state.
    #[must_use]
    pub fn free_run_error(&self, record: &Record, span: &Range<usize>, settling: usize) -> f64 {
        free_run_error(&self.plant(), record, std::slice::from_ref(span), settling)
    }

    /// Root mean square error of free runs over windows of a span, m.
    #[must_use]
    pub fn window_error(&self, record: &Record, span: &Range<usize>, samples: usize, settling: usize) -> f64 {
        free_run_error(&self.plant(), record, &Stage::Windows(samples).windows(span), settling)
    }
}

/// Root mean square error of free runs over windows, m; not a number where no sample counts.
pub(crate) fn free_run_error(
    plant: &Plant<f64>,
    record: &Record,
    windows: &[Range<usize>],
    settling: usize,
) -> f64 {
    let runs: Vec<f64> = windows.iter().flat_map(|w| errors(plant, plant, record, w, settling)).collect();
    if runs.is_empty() { f64::NAN } else { signals::rms(&runs) }
}

/// Held-out error of the whole structure, and of the structure without each of its terms.
///
/// Each model is fitted to one part and judged on the other, by `judge`; the square means over the pairs are compared.
///
/// # Errors
/// A part that does not determine the parameters.
pub fn gains(
    structure: &Structure,
    record: &Record,
    pairs: &[(Range<usize>, Range<usize>)],
    protocol: &Protocol,
    judge: &(dyn Fn(&Found, &Range<usize>) -> f64 + Sync),
    progress: &(dyn Fn(f32, &str) + Sync),
) -> Result<Vec<Gain>, Error> {
    let held_out = |left_out| -> Result<f64, Error> {
        let places = structure.without(left_out);
        let mut squares = 0.0;
        for (fitted, judged) in pairs {
            squares += judge(&identified(&places, record, fitted, protocol)?, judged).powi(2);
        }
        Ok((squares / pairs.len() as f64).sqrt())
    };
    let steps = structure.terms.len() + 1;
    progress(0.0, "held-out error");
    let with = held_out(None)?;
    let mut out = Vec::new();
    for (i, term) in structure.terms.iter().enumerate() {
        progress((i + 1) as f32 / steps as f32, &format!("without {}", term.name));
        out.push(Gain { term: term.name.into(), without: held_out(Some(i))?, with });
    }
    Ok(out)
}
