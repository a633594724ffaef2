//! What a body or a filter behind a measured signal does, sample by sample: the diagnosis looks for it in a recording, and a
//! model predicts with it.

use friction::mean_decay;
use std::f64::consts::TAU;

/// Acceleration of a load that hangs on a driven body by a spring and a damper, from that body's acceleration `drive`
/// (m/s²): a₂ = (2ζωs + ω²)/(s² + 2ζωs + ω²)·a with ω = 2π·`frequency` (Hz), at which the load would swing with the drive
/// held, and the damping ratio ζ. Trapezoidal rule, started in step.
#[must_use]
pub fn load_on_spring(drive: &[f64], frequency: f64, damping: f64, dt: f64) -> Vec<f64> {
    let (w, k) = (TAU * frequency, 2.0 / dt);
    let (spring, damper) = (w * w, 2.0 * damping * w * k);
    let a0 = k * k + damper + spring;
    let b = [damper + spring, 2.0 * spring, spring - damper].map(|x| x / a0);
    let a = [2.0 * (spring - k * k), k * k - damper + spring].map(|x| x / a0);
    let start = drive.first().copied().unwrap_or(0.0);
    let (mut x, mut y) = ([start; 2], [start; 2]);
    drive
        .iter()
        .map(|&now| {
            let out = b[0] * now + b[1] * x[0] + b[2] * x[1] - a[0] * y[0] - a[1] * y[1];
            (x, y) = ([now, x[0]], [out, y[0]]);
            out
        })
        .collect()
}

/// Acceleration of a free body inside a box of length `gap` that moves as `drive` (both m), with plastic blows at its ends:
/// a load behind a play.
#[must_use]
pub fn load_in_play(drive: &[f64], gap: f64, dt: f64) -> Vec<f64> {
    let half = 0.5 * gap;
    let (mut x, mut v) = (drive.first().copied().unwrap_or(0.0), 0.0_f64);
    let mut before = x;
    drive
        .iter()
        .map(|&at| {
            let speed = (at - before) / dt;
            before = at;
            let was = v;
            x += v * dt;
            if x > at + half {
                (x, v) = (at + half, v.min(speed));
            } else if x < at - half {
                (x, v) = (at - half, v.max(speed));
            }
            (v - was) / dt
        })
        .collect()
}

/// A series behind a first-order lag with time constant `lag`, s, started in its steady state; exact for a signal that is
/// straight between samples, so that a ramp comes late by the time constant and not by half a sample less.
#[must_use]
pub fn first_order_lag(series: &[f64], lag: f64, dt: f64) -> Vec<f64> {
    let in_lags = dt / lag.max(1e-300);
    let (keep, mean) = ((-in_lags).exp(), mean_decay(in_lags));
    let mut before = series.first().copied().unwrap_or(0.0);
    let mut state = before;
    series
        .iter()
        .map(|&x| {
            state = keep * state + (mean - keep) * before + (1.0 - mean) * x;
            before = x;
            state
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_load_follows_as_the_resonance_says() {
        let (dt, f_n, zeta) = (1e-4, 30.0, 0.1);
        for f in [3.0, 15.0, 27.0, 90.0] {
            let drive: Vec<f64> = (0..40_000).map(|i| (TAU * f * f64::from(i) * dt).sin()).collect();
            let load = load_on_spring(&drive, f_n, zeta, dt);
            let peak = load[20_000..].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            let r = f / f_n;
            let expected = (1.0 + (2.0 * zeta * r).powi(2)).sqrt()
                / ((1.0 - r * r).powi(2) + (2.0 * zeta * r).powi(2)).sqrt();
            println!("{f} Hz: {peak:.4}, closed form {expected:.4}");
            assert!((peak / expected - 1.0).abs() < 5e-3);
        }
    }

    #[test]
    fn a_load_flies_on_when_the_drive_turns_back() {
        let (dt, gap) = (1e-4, 0.02);
        // forward at 1 m/s for 0.1 s, then backward: the load crosses the play at 2 m/s against the drive
        let drive: Vec<f64> =
            (0..2000).map(|i| f64::from(i) * dt).map(|t| if t < 0.1 { t } else { 0.2 - t }).collect();
        let a = load_in_play(&drive, gap, dt);
        let blows: Vec<(usize, f64)> =
            a.iter().enumerate().filter(|(_, a)| a.abs() > 1.0).map(|(i, a)| (i, a * dt)).collect();
        println!("{blows:?}");
        // picked up after half the play, carried, caught at the other side
        assert_eq!(blows.len(), 2);
        assert!(blows[0].0.abs_diff(100) < 3 && (blows[0].1 - 1.0).abs() < 1e-6);
        assert!(blows[1].0.abs_diff(1100) < 3 && (blows[1].1 + 2.0).abs() < 1e-6);
    }

    #[test]
    fn a_ramp_is_late_by_the_time_constant() {
        let dt = 1e-3;
        let ramp: Vec<f64> = (0..400).map(|i| f64::from(i) * dt).collect();
        for lag in [0.3e-3, 1.6e-3, 20e-3] {
            let late = ramp[399] - first_order_lag(&ramp, lag, dt)[399];
            println!("{lag} s: {late:.6} s late");
            assert!((late - lag).abs() < 1e-9);
        }
    }
}
