//! The answer as one sentence for a person.

use crate::result::{Diagnosis, Verdict};

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
            let place = d.location.first().map_or_else(String::new, |l| {
                format!(
                    "; most of it shows over {} from {} to {} {}",
                    l.coordinate.replace('_', " "),
                    short(l.from),
                    short(l.to),
                    l.unit
                )
            });
            format!(
                "The simulation leaves out {list}{first}; with it the held-out error falls from {} to {} {unit}{place}.",
                short(d.baseline.rms_heldout),
                short(d.after.rms_heldout),
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
