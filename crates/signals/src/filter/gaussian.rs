//! A low-pass that never overshoots.

use super::continued;
use std::f64::consts::PI;

/// Standard deviations after which the kernel ends.
const REACH: f64 = 4.5;

/// A moving average with Gaussian weights: no phase, and no value outside the range of those it averages. What only grows still
/// only grows behind it; a Butterworth low-pass dips before a step.
///
/// ```
/// use signals::{Gaussian, LowPass, central_difference};
///
/// // a body at 1 mm/s that goes on at 100 mm/s after 1 s
/// let position: Vec<f64> = (0..2000).map(|i| 1e-6 * f64::from(i) + 99e-6 * f64::from((i - 1000).max(0))).collect();
/// let slowest = |x: Vec<f64>| central_difference(&x, 1e-3).into_iter().fold(f64::INFINITY, f64::min);
/// assert!((slowest(Gaussian::new(30.0, 1e-3).apply(&position)) - 1e-3).abs() < 1e-12);
/// assert!(slowest(LowPass::new(30.0, 1e-3).apply(&position)) < 0.0);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Gaussian {
    /// Weights of the middle sample and of those to one side.
    half: Vec<f64>,
}

impl Gaussian {
    /// Half power at `cutoff` Hz, for samples `dt` seconds apart.
    #[must_use]
    pub fn new(cutoff: f64, dt: f64) -> Self {
        // exp(−(2π·f·σ)²/2) = 1/√2 at the cut-off
        let sigma = std::f64::consts::LN_2.sqrt() / (2.0 * PI * cutoff * dt);
        let reach = (REACH * sigma).ceil().clamp(1.0, 1e6) as usize;
        let mut half: Vec<f64> = (0..=reach).map(|i| (-0.5 * (i as f64 / sigma).powi(2)).exp()).collect();
        let sum = 2.0 * half.iter().sum::<f64>() - half[0];
        half.iter_mut().for_each(|w| *w /= sum);
        Self { half }
    }

    /// Filters a series; the ends are continued by odd reflection, as far as the series goes.
    #[must_use]
    pub fn apply(&self, series: &[f64]) -> Vec<f64> {
        let reach = (self.half.len() - 1).min(series.len().saturating_sub(1));
        let padded = continued(series.as_chunks::<1>().0, reach);
        let sum: f64 = self.half[..=reach].iter().sum::<f64>() * 2.0 - self.half[0];
        let around = |i: usize| {
            let sides = (1..=reach).map(|k| self.half[k] * (padded[i - k][0] + padded[i + k][0]));
            (self.half[0] * padded[i][0] + sides.sum::<f64>()) / sum
        };
        (reach..reach + series.len()).map(around).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_power_passes_at_the_cutoff() {
        let (dt, cutoff) = (1e-3, 40.0);
        let wave: Vec<f64> = (0..4000).map(|i| (2.0 * PI * cutoff * f64::from(i) * dt).sin()).collect();
        let behind = Gaussian::new(cutoff, dt).apply(&wave);
        let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
        assert!((rms(&behind[500..3500]) / rms(&wave[500..3500]) - 0.5_f64.sqrt()).abs() < 1e-4);
    }

    #[test]
    fn straight_lines_pass_whatever_their_length() {
        for n in [0, 1, 2, 5, 100] {
            let line: Vec<f64> = (0..n).map(|i| 3.0 - 0.5 * f64::from(i)).collect();
            let behind = Gaussian::new(2.0, 0.1).apply(&line);
            assert_eq!(behind.len(), line.len());
            assert!(behind.iter().zip(&line).all(|(a, b)| (a - b).abs() < 1e-12), "{n}");
        }
    }
}
