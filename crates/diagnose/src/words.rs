//! The answer as one sentence for a person.

use crate::channel::OF_CHANNELS;
use crate::result::{Diagnosis, Verdict};

/// Force error without and with what is missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Errors {
    pub before: f64,
    pub after: f64,
    /// Of single samples, the channel as recorded against the channel set right: all that is missing was told by
    /// comparing channels and is gone from what was fitted. Otherwise behind the filter, on data the fit did not see.
    pub of_samples: bool,
}

impl Errors {
    pub(crate) fn of(d: &Diagnosis) -> Self {
        match d.missing.first() {
            Some(m) if d.missing.iter().all(|m| OF_CHANNELS.iter().any(|e| e.0 == m.effect)) => {
                Self { before: m.rms_heldout_before, after: m.rms_heldout_after, of_samples: true }
            }
            _ => Self { before: d.baseline.rms_heldout, after: d.after.rms_heldout, of_samples: false },
        }
    }
}

/// One sentence: what is missing, or that nothing is, and how sure that is.
pub fn summary(d: &Diagnosis) -> String {
    let unit = &d.noise_floor.unit;
    match d.verdict {
        Verdict::NotTestable => "This recording cannot answer.".into(),
        Verdict::NoMismatch => format!(
            "The model explains this recording down to its noise ({:.3} {unit}); an effect of more than about {} {unit} \
             would have been seen.",
            d.baseline.rms_heldout,
            short(d.detectable),
        ),
        Verdict::Mismatch => {
            let names: Vec<String> = d.missing.iter().map(|m| m.effect.replace('_', " ")).collect();
            let list = match names.as_slice() {
                [] => "something no law of the catalogue fits".to_string(),
                [one] => one.clone(),
                [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
            };
            let first =
                d.missing.first().map_or_else(String::new, |m| format!(": {}", m.says.trim_end_matches('.')));
            let Errors { before, after, of_samples } = Errors::of(d);
            let place = d.location.first().map_or_else(String::new, |l| {
                format!(
                    "; most of it shows over {} from {} to {} {}",
                    l.coordinate.replace('_', " "),
                    short(l.from),
                    short(l.to),
                    l.unit
                )
            });
            let falls = if of_samples {
                "set right, the error of a force sample"
            } else {
                "with it the held-out error"
            };
            format!(
                "The simulation leaves out {list}{first}; {falls} falls from {} to {} {unit}{place}.",
                short(before),
                short(after),
            )
        }
    }
}

/// Three significant digits.
fn short(x: f64) -> String {
    if !x.is_finite() {
        return "—".into();
    }
    if x == 0.0 {
        return "0".into();
    }
    let digits = (2 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
    format!("{x:.digits$}")
}
