//! Errors of a prediction, over what the motion determines and over everything.

use report::number::number;
use signals::{LowPass, Recording, noise_std};
use std::fmt::Write;

/// Errors of a prediction where a force is recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictionErrors {
    /// Samples of the recording.
    pub samples: usize,
    /// Samples with a force and a prediction.
    pub compared: usize,
    /// How many of them slide: there the motion determines the force.
    pub sliding: usize,
    /// Root mean square over all of them: of the error, of the force.
    pub all: (f64, f64),
    /// The same over those that slide.
    pub determined: (f64, f64),
    /// The same behind the filter, and its cut-off, Hz.
    pub filtered: Option<(f64, f64, f64)>,
    /// Standard deviation of the recorded force's noise.
    pub noise: f64,
}

impl PredictionErrors {
    /// Compares a prediction with the recorded force.
    #[must_use]
    pub fn of(recording: &Recording, predicted: &[f64], is_sliding: &[bool], cutoff: Option<f64>) -> Self {
        let pairs: Vec<(f64, f64, bool)> = recording
            .force
            .iter()
            .zip(predicted)
            .zip(is_sliding)
            .filter(|((f, p), _)| f.is_finite() && p.is_finite())
            .map(|((f, p), s)| (f - p, *f, *s))
            .collect();
        let rms = |wanted: &dyn Fn(&(f64, f64, bool)) -> bool| -> (f64, f64) {
            let (mut error, mut force, mut count) = (0.0, 0.0, 0.0);
            for (e, f, _) in pairs.iter().filter(|p| wanted(p)) {
                (error, force, count) = (error + e * e, force + f * f, count + 1.0);
            }
            (f64::sqrt(error / f64::max(count, 1.0)), f64::sqrt(force / f64::max(count, 1.0)))
        };
        let filtered = cutoff.zip(recording.sample_period()).map(|(cutoff, dt)| {
            // what is not determined is taken out in front of the filter, as in the diagnosis
            let kept = |of: &dyn Fn(&(f64, f64, bool)) -> f64| -> Vec<f64> {
                pairs.iter().map(|p| if p.2 { of(p) } else { 0.0 }).collect()
            };
            let low_pass = LowPass::new(cutoff, dt);
            let [error, force] = [low_pass.apply(&kept(&|p| p.0)), low_pass.apply(&kept(&|p| p.1))];
            let over = |series: &[f64]| {
                let inside = series.iter().zip(&pairs).filter(|(_, p)| p.2).map(|(x, _)| x * x);
                let (sum, count) = inside.fold((0.0, 0.0), |(s, n), x| (s + x, n + 1.0));
                f64::sqrt(sum / f64::max(count, 1.0))
            };
            (over(&error), over(&force), cutoff)
        });
        Self {
            samples: predicted.len(),
            compared: pairs.len(),
            sliding: pairs.iter().filter(|p| p.2).count(),
            all: rms(&|_| true),
            determined: rms(&|p| p.2),
            filtered,
            noise: noise_std(&recording.force),
        }
    }

    /// Root mean square of the unfiltered residual, and its share of the force; None where no force was measured.
    #[must_use]
    pub fn residual(&self) -> Option<(f64, f64)> {
        let (error, force) = self.all;
        (force > 0.0).then(|| (error, error / force))
    }

    /// In words, for a terminal; `unit` is that of the force.
    #[must_use]
    pub fn words(&self, file: &str, unit: &str) -> String {
        let of_force = |(error, force): (f64, f64)| {
            let share = if force > 0.0 {
                format!(", {:.2} % of the force", 100.0 * error / force)
            } else {
                String::new()
            };
            format!("{} {unit} rms{share}", number(error, 4))
        };
        let mut out = format!("{file}: {} samples\n", self.samples);
        if self.compared == 0 || self.all.1 <= 0.0 {
            return out;
        }
        let share = 100.0 * self.sliding as f64 / self.compared as f64;
        if self.sliding > 0 {
            let (what, at) = match self.filtered {
                Some((error, force, cutoff)) => ((error, force), format!(" behind {cutoff:.0} Hz")),
                None => (self.determined, String::new()),
            };
            let _ = writeln!(
                out,
                "  sliding, {share:.0} % of the samples, where the motion determines the force: residual{at} {}",
                of_force(what)
            );
            let _ = writeln!(
                out,
                "  the same unfiltered: {}, of which the noise of the recorded force is {} {unit}",
                of_force(self.determined),
                number(self.noise, 4)
            );
        }
        let _ = writeln!(
            out,
            "  all samples, unfiltered: {}{}",
            of_force(self.all),
            if share < 99.5 {
                "; at rest friction is whatever balances, see the column of the standard deviation"
            } else {
                ""
            }
        );
        out
    }
}
