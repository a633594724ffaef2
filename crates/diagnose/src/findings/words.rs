//! The answer in one sentence.

use crate::findings::channel::told_by_channels;
use crate::result::{Diagnosis, Verdict};
use friction::effects::{Describe, Unnamed};

/// Force error without and with what is missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceError {
    /// Without it, N or N·m.
    pub before: f64,
    /// With it.
    pub after: f64,
    /// Of single samples, the channel as recorded against the channel set right: all that is missing was told by
    /// comparing channels and is gone from what was fitted. Otherwise behind the filter, on data the fit did not see.
    pub of_samples: bool,
    /// Of the recordings or the regime that was left out, rather than of blocks held out.
    pub left_out: bool,
}

impl ForceError {
    /// Of this diagnosis.
    #[must_use]
    pub fn of(d: &Diagnosis) -> Self {
        match d.missing.first() {
            Some(m) if d.missing.iter().all(|m| told_by_channels(&m.effect)) => Self {
                before: m.rms_heldout_before,
                after: m.rms_heldout_after,
                of_samples: true,
                left_out: false,
            },
            _ => match &d.left_out {
                Some(l) => {
                    Self { before: l.rms_before, after: l.rms_after, of_samples: false, left_out: true }
                }
                None => Self {
                    before: d.baseline.rms_heldout,
                    after: d.after.rms_heldout,
                    of_samples: false,
                    left_out: false,
                },
            },
        }
    }
}

/// Part of the recording of which the verdict speaks, where that is not nearly all of it.
fn judged(d: &Diagnosis) -> String {
    let share = 100.0 * d.judged_share;
    if share > 95.0 {
        return String::new();
    }
    format!(" in the {share:.0} % of its samples at which the body surely slides")
}

/// Each id once, in the order of its first appearance.
pub(crate) fn distinct<'a>(ids: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut out = Vec::new();
    for id in ids {
        if !out.contains(&id) {
            out.push(id);
        }
    }
    out
}

/// The words for an effect, and how many times it was found.
fn name(d: &Diagnosis, id: &str) -> String {
    if id == Unnamed::ABOUT.id {
        return "something that no law of the catalogue fits".into();
    }
    let words = id.replace('_', " ");
    match d.missing.iter().filter(|m| m.effect == id).count() {
        0 | 1 => words,
        2 => format!("{words} twice"),
        n => format!("{words} {n} times"),
    }
}

/// One sentence: what is missing, or that nothing is, and how sure that is.
#[must_use]
pub fn summary(d: &Diagnosis) -> String {
    let unit = &d.noise_floor.unit;
    match d.verdict {
        Verdict::NotTestable => "This recording cannot answer.".into(),
        Verdict::NoMismatch if !d.is_down_to_its_noise() => format!(
            "No law and no curve over the motion explains what the model leaves{}, {} {unit} where the noise is {} {unit}: too \
             little to be located, and more than nothing. An effect of more than about {} {unit} would have been seen.",
            judged(d),
            short(d.baseline.rms_heldout),
            short(d.noise_floor.rms),
            short(d.detectable),
        ),
        Verdict::NoMismatch => format!(
            "The model explains this recording down to its noise ({:.3} {unit}){}; an effect of more than about {} {unit} \
             would have been seen.",
            d.baseline.rms_heldout,
            judged(d),
            short(d.detectable),
        ),
        Verdict::Mismatch => {
            let ids = distinct(d.missing.iter().map(|m| m.effect.as_str()));
            let names: Vec<String> = ids.into_iter().map(|id| name(d, id)).collect();
            let list = match names.as_slice() {
                [] => "something no law of the catalogue fits".to_string(),
                [one] => one.clone(),
                [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
            };
            let first =
                d.missing.first().map_or_else(String::new, |m| format!(": {}", m.says.trim_end_matches('.')));
            let ForceError { before, after, of_samples, left_out } = ForceError::of(d);
            let place = d.location.first().map_or_else(String::new, |l| {
                format!(
                    "; most of it shows over {} from {} to {} {}",
                    l.coordinate.replace('_', " "),
                    short(l.from),
                    short(l.to),
                    l.unit
                )
            });
            let error = match &d.left_out {
                _ if of_samples => "set right, the error of a force sample".to_string(),
                Some(l) if left_out => format!("on {}, which was not fitted, the error", l.on),
                _ => "with it the held-out error".to_string(),
            };
            let change = match (short(before), short(after)) {
                (before, after) if before == after => format!("is {before}"),
                (b, a) if after < before => format!("falls from {b} to {a}"),
                (b, a) => format!("rises from {b} to {a}"),
            };
            format!("The simulation leaves out {list}{first}; {error} {change} {unit}{place}.")
        }
    }
}

/// Three significant digits.
pub(crate) fn short(x: f64) -> String {
    if !x.is_finite() {
        return "—".into();
    }
    if x == 0.0 {
        return "0".into();
    }
    let digits = (2 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
    format!("{x:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Friction that rises at rest and is gone within a millimetre: 0.036 N were left, and called the noise, of 0.018 N.
    #[test]
    fn an_error_of_twice_the_noise_was_called_the_noise() {
        let mut d = crate::pipeline::unanswered(Vec::new(), Vec::new(), 0.018, "N".into(), "of no motion");
        (d.verdict, d.judged_share, d.detectable) = (Verdict::NoMismatch, 1.0, 0.054);
        d.baseline.rms_heldout = 0.036;
        assert!(summary(&d).contains("0.0360 N where the noise is 0.0180 N"), "{}", summary(&d));
        d.baseline.rms_heldout = 0.020;
        assert!(summary(&d).contains("down to its noise (0.020 N)"), "{}", summary(&d));
    }
}
