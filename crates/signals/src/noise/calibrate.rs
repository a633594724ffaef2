//! Calibration of one channel against another [thesis, ch. 3.5.3].

use crate::filter::{Filter, four_point_difference, zero_phase};
use crate::noise::noise_variance;
use crate::stretches::rms_frequency;

/// Scale and offset that bring an accelerometer into agreement with the motion: a = scale·reading + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// No unit.
    pub scale: f64,
    /// m/s² or rad/s².
    pub offset: f64,
    /// Standard deviation of `scale`, counting only as many samples as the low-pass lets be independent.
    pub scale_std: f64,
    /// Standard deviation of `offset`, m/s² or rad/s², counted alike.
    pub offset_std: f64,
    /// Share of the differentiated velocity's variance that the accelerometer explains, 0 to 1.
    pub r_squared: f64,
}

/// Scales and offsets an accelerometer so that it best matches the velocity differentiated by four-point central
/// differences, `dt` s apart.
///
/// Both are compared behind one zero-phase low-pass at ten times the frequency of the motion, without which the noise
/// of a differentiated velocity would be 6 % of the scale in the setting of [thesis, ch. 3.5.3]; and the accelerometer's noise
/// is taken out of its variance, as in [thesis, eq. 3.9], because plain regression would scale it down. None for columns of
/// different lengths, fewer than 32 samples, or a motion without acceleration.
#[must_use]
pub fn calibrate_accelerometer(reading: &[f64], velocity: &[f64], dt: f64) -> Option<Calibration> {
    let n = reading.len();
    if n != velocity.len() || n < 32 || !(dt > 0.0) {
        return None;
    }
    let moving = rms_frequency(velocity, dt);
    let cutoff_hz = (10.0 * moving).clamp(8.0 / (n as f64 * dt), 0.2 / dt);
    let filter = Filter::butterworth(4, cutoff_hz, dt).ok()?;
    let filtered = zero_phase(&filter, reading);
    let expected = zero_phase(&filter, &four_point_difference(velocity, dt));
    let trim = filter.settle().min(n / 8);
    let noise = noise_variance(reading) * filter_variance_gain(&filter);
    let line = Line::through(&filtered[trim..n - trim], &expected[trim..n - trim], noise)?;
    let independent = (2.0 * cutoff_hz * dt * (n - 2 * trim) as f64).max(3.0);
    let inner = &expected[trim..n - trim];
    let mean = inner.iter().sum::<f64>() / inner.len() as f64;
    let spread = inner.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / inner.len() as f64;
    Some(Calibration {
        offset_std: (spread * (1.0 - line.r_squared).max(0.0) / (independent - 2.0)).sqrt(),
        scale: line.slope,
        offset: line.offset,
        scale_std: (line.slope * line.slope * (1.0 / line.r_squared.max(1e-12) - 1.0) / (independent - 2.0))
            .sqrt(),
        r_squared: line.r_squared,
    })
}

/// Variance behind the zero-phase filter of white noise of unit variance in front of it.
pub(crate) fn filter_variance_gain(filter: &Filter) -> f64 {
    crate::filter::white_gain(|f| filter.gain(f).powi(2))
}

/// y = slope·x + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    pub slope: f64,
    pub offset: f64,
    /// Squared correlation.
    pub r_squared: f64,
}

impl Line {
    /// The regression of `y` on `x`, whose own error has the variance `noise`.
    pub fn through(x: &[f64], y: &[f64], noise: f64) -> Option<Self> {
        let n = x.len().min(y.len());
        if n < 3 {
            return None;
        }
        let mean = |s: &[f64]| s.iter().take(n).sum::<f64>() / n as f64;
        let (mx, my) = (mean(x), mean(y));
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (x, y) in x.iter().zip(y) {
            xx += (x - mx) * (x - mx);
            xy += (x - mx) * (y - my);
            yy += (y - my) * (y - my);
        }
        let signal = xx - n as f64 * noise;
        // Channels whose noise is all there is cannot be compared.
        if !(signal > 0.1 * xx && yy > 0.0 && xy.is_finite()) {
            return None;
        }
        let slope = xy / signal;
        Some(Self { slope, offset: my - slope * mx, r_squared: (xy * xy / (xx * yy)).min(1.0) })
    }
}
