//! Results of the targeting task [thesis, ch. 5.4.1], checked on given sessions.

use crate::{Difference, Resistance};
use serde::Serialize;
use std::collections::BTreeMap;

/// Narrow targets: the three most difficult indices [thesis, ch. 5.4.1].
pub const HARD: [u32; 3] = [1, 4, 7];

/// Whether sessions agree with a reported result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shown {
    /// The 95 % interval lies on the reported side.
    Yes,
    /// It contains zero.
    Open,
    /// It lies on the other side.
    Contradicted,
}

/// A reported result with its check.
#[derive(Debug, Clone, Serialize)]
pub struct Claim {
    /// Reported result.
    pub claim: &'static str,
    /// Of the mean.
    pub unit: &'static str,
    /// Mean over subjects of their mean change against their own baseline, on the narrow targets.
    pub mean: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// What that says.
    pub shown: Shown,
}

/// All that can be asked with two subjects or more.
pub fn claims(differences: &[Difference]) -> Vec<Claim> {
    use Resistance::{HighStiction, Real, Simulated, Viscous};
    type Value = fn(&Difference) -> f64;
    let share: Value = |d| 100.0 * d.time_s / d.baseline_s;
    let errors: Value = |d| d.errors;
    let asked: [(&'static str, &[Resistance], Value, &'static str, f64); 6] = [
        (
            "moderate friction, real or rendered, is faster on narrow targets",
            &[Real, Simulated],
            share,
            "%",
            -1.0,
        ),
        (
            "moderate friction makes fewer errors on narrow targets",
            &[Real, Simulated],
            errors,
            "errors",
            -1.0,
        ),
        ("rendered friction does as real friction does (difference in time)", &[Simulated], share, "%", 0.0),
        ("high stiction is slower on narrow targets", &[HighStiction], share, "%", 1.0),
        ("high stiction makes more errors on narrow targets", &[HighStiction], errors, "errors", 1.0),
        ("viscous damping is faster on narrow targets", &[Viscous], share, "%", -1.0),
    ];
    let by_subject = |of: &[Resistance], value: Value| {
        let mut sums: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
        for d in differences.iter().filter(|d| of.contains(&d.resistance) && HARD.contains(&d.index)) {
            let sum = sums.entry(&d.subject).or_default();
            *sum = (sum.0 + value(d), sum.1 + 1.0);
        }
        sums.into_iter().map(|(subject, (sum, n))| (subject, sum / n)).collect::<BTreeMap<_, _>>()
    };
    let mut out = Vec::new();
    for (claim, of, value, unit, side) in asked {
        let mut values = by_subject(of, value);
        if side == 0.0 {
            let real = by_subject(&[Real], value);
            values = values.iter().filter_map(|(s, x)| Some((*s, x - real.get(s)?))).collect();
        }
        let values: Vec<f64> = values.into_values().collect();
        let n = values.len() as f64;
        if values.len() < 2 {
            continue;
        }
        let mean = values.iter().sum::<f64>() / n;
        let sd = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let half = student(n - 1.0) * sd / n.sqrt();
        let ci95 = [mean - half, mean + half];
        let shown = match (ci95[0] > 0.0, ci95[1] < 0.0) {
            (false, false) if side == 0.0 => Shown::Yes,
            (false, false) => Shown::Open,
            (up, _) if (up && side > 0.0) || (!up && side < 0.0) => Shown::Yes,
            _ => Shown::Contradicted,
        };
        out.push(Claim { claim, unit, mean, ci95, shown });
    }
    out
}

/// 97.5 % point of Student's distribution, to a per cent from 2 degrees of freedom on [cornish-1938].
fn student(freedom: f64) -> f64 {
    let z = 1.959_964_f64;
    let (z3, z5, z7) = (z.powi(3), z.powi(5), z.powi(7));
    z + (z3 + z) / (4.0 * freedom)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * freedom.powi(2))
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * freedom.powi(3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn student_as_in_tables() {
        for (freedom, table) in [(2.0, 4.303), (4.0, 2.776), (9.0, 2.262), (19.0, 2.093), (60.0, 2.000)] {
            assert!((student(freedom) / table - 1.0).abs() < 0.04, "{freedom}: {}", student(freedom));
        }
    }

    #[test]
    fn a_claim_is_shown_contradicted_or_neither() {
        let of = |change: f64| -> Vec<Difference> {
            (0..20)
                .flat_map(|k| {
                    HARD.map(|index| Difference {
                        subject: format!("s{k}"),
                        simulated: false,
                        resistance: Resistance::Real,
                        index,
                        // subjects differ by a second
                        time_s: change + f64::from(k % 5 - 2) * 0.5,
                        errors: change,
                        error_mm: 0.0,
                        baseline_s: 8.0,
                    })
                })
                .collect()
        };
        let faster = |change: f64| claims(&of(change))[0].shown;
        assert_eq!(faster(-1.0), Shown::Yes);
        assert_eq!(faster(0.05), Shown::Open);
        assert_eq!(faster(1.0), Shown::Contradicted);
    }
}
