//! Drive and load are two bodies on a spring: the load follows the drive through a resonance, so that the mass the
//! drive feels rises with frequency. On one sine exactly a mass (U = 0); a chirp or a pulse shows it.
//!
//! The load's acceleration a₂ is that of the encoder's body behind the exact resonance, and not the first term of its
//! series, a fourth derivative of the position: near the resonance the series is wrong, and above it the load smooths
//! the encoder's noise, which the series differentiates. The encoder is taken to sit on the drive.

use super::Sensor;
use crate::track::Track;
use friction::effects::Parameter;
use std::f64::consts::TAU;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "compliance",
    says: "drive and load are two masses with a spring between them",
    equation: "F = m·a + m_load·(a₂ − a), a₂ = (2ζωs + ω²)/(s² + 2ζωs + ω²)·a, ω = 2π·frequency",
    gains: &[Parameter { name: "mass", unit: "kg", min: 0.0, max: 1e6, what: "mass of the load" }],
    shape: &[
        Parameter {
            name: "frequency",
            unit: "Hz",
            min: 0.1,
            max: 1e4,
            what: "at which the load would swing with the drive held",
        },
        Parameter { name: "damping", unit: "1", min: 0.02, max: 0.6, what: "damping ratio ζ of that" },
    ],
    columns,
};

fn columns(track: &Track, shape: &[f64; 2]) -> Vec<Vec<f64>> {
    let follows = follow(&track.a, shape[0], shape[1], track.raw.dt);
    vec![follows.iter().zip(&track.a).map(|(load, drive)| load - drive).collect()]
}

/// What a body shows that hangs on a driven one by a spring and a damper (trapezoidal rule), started in step.
fn follow(drive: &[f64], frequency: f64, damping: f64, dt: f64) -> Vec<f64> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_load_follows_as_the_resonance_says() {
        let (dt, f_n, zeta) = (1e-4, 30.0, 0.1);
        for f in [3.0, 15.0, 27.0, 90.0] {
            let drive: Vec<f64> = (0..40_000).map(|i| (TAU * f * f64::from(i) * dt).sin()).collect();
            let load = follow(&drive, f_n, zeta, dt);
            let peak = load[20_000..].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            let r = f / f_n;
            let expected = (1.0 + (2.0 * zeta * r).powi(2)).sqrt()
                / ((1.0 - r * r).powi(2) + (2.0 * zeta * r).powi(2)).sqrt();
            println!("{f} Hz: {peak:.4}, closed form {expected:.4}");
            assert!((peak / expected - 1.0).abs() < 5e-3);
        }
    }
}
