//! What white noise is worth behind filters and differences.

use std::f64::consts::PI;

/// Mean of |T|² up to half the sampling rate: variance behind a transfer of white noise of unit variance. `transfer`
/// is |T| at a frequency given as a fraction of half the rate.
pub fn white_gain(transfer: impl Fn(f64) -> f64) -> f64 {
    const POINTS: usize = 2000;
    // Squared spacing: low cut-offs are integrated as finely as high ones.
    (0..POINTS)
        .map(|i| {
            let u = (i as f64 + 0.5) / POINTS as f64;
            2.0 * u / POINTS as f64 * transfer(u * u).powi(2)
        })
        .sum()
}

/// |T| of the four-point central difference at a fraction of half the sampling rate, 1/s.
pub fn four_point_gain(fraction: f64, dt: f64) -> f64 {
    let w = PI * fraction;
    ((8.0 * w.sin() - (2.0 * w).sin()) / (6.0 * dt)).abs()
}

/// |T| of the two-point central difference, 1/s.
pub fn central_gain(fraction: f64, dt: f64) -> f64 {
    ((PI * fraction).sin() / dt).abs()
}
