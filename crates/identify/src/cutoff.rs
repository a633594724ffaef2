//! Where the default filter cuts, and what white noise is worth behind filters and differences.

use std::f64::consts::PI;

/// Share of the acceleration that its noise may be behind the filter.
pub(crate) const NOISE_SHARE: f64 = 0.05;

/// Mean of |T|² up to half the sampling rate: variance behind a transfer of white noise of unit variance. `transfer`
/// is |T| at a frequency given as a fraction of half the rate.
pub(crate) fn white_gain(transfer: impl Fn(f64) -> f64) -> f64 {
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
pub(crate) fn four_point_gain(fraction: f64, dt: f64) -> f64 {
    let w = PI * fraction;
    ((8.0 * w.sin() - (2.0 * w).sin()) / (6.0 * dt)).abs()
}

/// |T| of the two-point central difference, 1/s.
pub(crate) fn central_gain(fraction: f64, dt: f64) -> f64 {
    ((PI * fraction).sin() / dt).abs()
}

/// The highest cut-off, in Hz, at which `noise(cutoff)`, the standard deviation of the acceleration's error, is
/// below [`NOISE_SHARE`] of `signal(cutoff)`, its root mean square; from a tenth of the sampling rate downward in
/// steps of a fifth, but not below `floor`.
pub(crate) fn choose(dt: f64, floor: f64, noise: impl Fn(f64) -> f64, signal: impl Fn(f64) -> f64) -> f64 {
    let highest = 0.1 / dt;
    let floor = floor.min(highest);
    let mut cutoff = highest;
    while cutoff > floor {
        let (error, all) = (noise(cutoff), signal(cutoff));
        if error <= NOISE_SHARE * (all * all - error * error).max(0.0).sqrt() {
            return cutoff;
        }
        cutoff *= 0.8;
    }
    floor
}
