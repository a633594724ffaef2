//! Effects of sensors and drive on whole series: one forward operator, with which a fit looks for them and a model predicts.

use super::{Describe, MAX_SHAPE};
use alloc::vec::Vec;

/// One stretch of a motion at an even rate, and the force that acts in it. All series have one length.
#[derive(Debug, Clone, Copy)]
pub struct Record<'a> {
    /// Sample period, s.
    pub dt: f64,
    /// Position, m or rad, without the noise of its sensor.
    pub position: &'a [f64],
    /// Acceleration, m/s² or rad/s².
    pub acceleration: &'a [f64],
    /// Sign of the velocity: −1, 0 or 1.
    pub direction: &'a [f64],
    /// Force that acts, N or N·m.
    pub force: &'a [f64],
}

/// An effect on a whole series: linear in its gains once its shape is given.
pub trait Operator: Describe {
    /// What a unit of gain `gain` adds to the force that acts, at every sample.
    fn added(gain: usize, shape: &[f64; MAX_SHAPE], record: &Record<'_>) -> Vec<f64>;

    /// The force that acts, from the one that is `shown` through a unit of gain `gain`. As it is shown, for an effect that
    /// does not move the whole force in time.
    #[must_use]
    fn restored(_gain: usize, _shape: &[f64; MAX_SHAPE], shown: &[f64], _dt: f64) -> Vec<f64> {
        shown.to_vec()
    }

    /// Time by which the force is late as it is, s.
    #[must_use]
    fn delay(_gains: &[f64], _shape: &[f64; MAX_SHAPE]) -> f64 {
        0.0
    }

    /// Time constant of a low-pass that the channel of the force has and those of the motion have not, s.
    #[must_use]
    fn low_pass(_gains: &[f64], _shape: &[f64; MAX_SHAPE]) -> Option<f64> {
        None
    }
}

/// `series` later by `delay` s, between samples by the cubic through four of them; its ends are held.
///
/// ```
/// # use friction::effects::delayed;
/// assert_eq!(delayed(&[0.0, 1.0, 4.0, 9.0, 16.0], 1e-3, 1e-3), [0.0, 0.0, 1.0, 4.0, 9.0]);
/// ```
#[must_use]
pub fn delayed(series: &[f64], delay: f64, dt: f64) -> Vec<f64> {
    let last = series.len().saturating_sub(1);
    let at = |i: isize| series[i.clamp(0, last as isize) as usize];
    (0..series.len())
        .map(|i| {
            let t = (i as f64 - delay / dt).clamp(0.0, last as f64);
            let low = t as isize;
            let s = t - low as f64;
            // Lagrange's weights: linear interpolation would be a low-pass, strongest half-way
            let (before, after) = (s + 1.0, s - 1.0);
            let far = s - 2.0;
            at(low - 1) * (-s * after * far / 6.0)
                + at(low) * (before * after * far / 2.0)
                + at(low + 1) * (-before * s * far / 2.0)
                + at(low + 2) * (before * s * after / 6.0)
        })
        .collect()
}

/// Derivative by central differences, one-sided at the ends.
pub(super) fn derivative(series: &[f64], dt: f64) -> Vec<f64> {
    let last = series.len().saturating_sub(1);
    (0..series.len())
        .map(|i| {
            let (low, high) = (i.saturating_sub(1), (i + 1).min(last));
            if high > low { (series[high] - series[low]) / ((high - low) as f64 * dt) } else { 0.0 }
        })
        .collect()
}

/// Sample by sample, `a` less `b`.
pub(super) fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use std::println;

    #[test]
    fn a_delay_between_samples_keeps_a_fast_wave() {
        let wave = |t: f64| (TAU * 100.0 * t).sin();
        let series: Vec<f64> = (0..2000).map(|i| wave(f64::from(i) * 1e-3)).collect();
        let late = delayed(&series, 0.5e-3, 1e-3);
        let worst = (10..1990).map(|i| (late[i] - wave(i as f64 * 1e-3 - 0.5e-3)).abs()).fold(0.0, f64::max);
        println!("100 Hz at 1 kHz, half a sample late: worst error {worst:.4}");
        assert!(worst < 0.01);
    }

    #[test]
    fn short_series_stay() {
        assert!(delayed(&[], 1.0, 1e-3).is_empty() && derivative(&[], 1e-3).is_empty());
        assert_eq!(delayed(&[2.0], 1.0, 1e-3), [2.0]);
        assert_eq!(derivative(&[2.0], 1e-3), [0.0]);
    }
}
