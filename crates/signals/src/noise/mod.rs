//! White noise of a channel, estimated from the scatter of samples about their neighbours.

mod calibrate;
mod sources;

pub(crate) use calibrate::filter_variance_gain;
pub use calibrate::{Calibration, calibrate_accelerometer};
pub use sources::{Source, Sources};

/// Variance of the white noise of a channel, from its third differences: Var Δ³x = 20 σ².
///
/// A motion that is smooth over four samples drops out. The largest fifth of the differences is left out, so that
/// reversals and stick-slip do not count as noise. A quantised channel has at least its quantum²/12. Values that are
/// not numbers are skipped; fewer than 16 samples say nothing and give 0.
#[must_use]
pub fn noise_variance(series: &[f64]) -> f64 {
    let mut squares: Vec<f64> = series
        .windows(4)
        .map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2))
        .filter(|d| d.is_finite())
        .collect();
    if squares.len() < 13 {
        return 0.0;
    }
    let kept = squares.len() * 4 / 5;
    squares.select_nth_unstable_by(kept, f64::total_cmp);
    squares.truncate(kept);
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    // Of a normal variable cut at its 80 % quantile 0.4377 of the variance is left.
    (mean / (20.0 * 0.4377)).max(quantum(series).powi(2) / 12.0)
}

/// Standard deviation of the white noise of a channel: the root of [`noise_variance`].
#[must_use]
pub fn noise_std(series: &[f64]) -> f64 {
    noise_variance(series).sqrt()
}

/// The step a channel is quantised in; 0 for a continuous one.
#[must_use]
pub fn quantum(series: &[f64]) -> f64 {
    let mut steps: Vec<f64> =
        series.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| d.is_finite() && *d > 0.0).collect();
    let Some(largest) = series.iter().filter(|x| x.is_finite()).map(|x| x.abs()).reduce(f64::max) else {
        return 0.0;
    };
    // Rounding in the last place is no quantum of the sensor.
    steps.retain(|s| *s > 1e-11 * largest);
    if steps.len() < 16 {
        return 0.0;
    }
    let rank = steps.len() / 100;
    let smallest = *steps.select_nth_unstable_by(rank, f64::total_cmp).1;
    // A continuous channel's steps are not multiples of one; a share of 0.98 to chance would need tolerance 0.98.
    let multiples = steps.iter().filter(|s| ((*s / smallest) - (*s / smallest).round()).abs() < 0.05).count();
    if multiples * 10 > steps.len() * 9 { smallest } else { 0.0 }
}
