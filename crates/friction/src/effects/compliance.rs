//! Drive and load, two bodies on a spring.

use super::{About, Acts, Describe, Parameter, Quantity, Scale, Seat};
use crate::Dimension;

/// Two masses with a spring between them: the load follows the drive through a resonance, so that the mass the drive feels
/// rises with frequency.
///
/// The load's acceleration a₂ is that of the encoder's body behind the exact resonance, and not the first term of its
/// series, a fourth derivative of the position: near the resonance the series is wrong, and above it the load smooths
/// the encoder's noise, which the series differentiates. The encoder is taken to sit on the drive.
///
/// ```
/// # #[cfg(feature = "alloc")] {
/// use friction::effects::{Record, SeriesKind};
///
/// let w = std::f64::consts::TAU * 10.0;
/// let drive: Vec<f64> = (0..8000).map(|i| (w * f64::from(i) * 5e-4).sin()).collect();
/// let rest = vec![0.0; 8000];
/// let record = Record { dt: 5e-4, position: &rest, acceleration: &drive, direction: &rest, force: &rest };
/// let extra = SeriesKind::Compliance.added(0, &[20.0, 0.02], &record);
/// let peak = extra[6000..].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
/// assert!((peak - 1.0 / 3.0).abs() < 1e-3); // at half the resonance the load swings by 4/3 of the drive
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compliance;

impl Describe for Compliance {
    const ABOUT: About = About {
        id: "compliance",
        says: "drive and load are two masses with a spring between them",
        equation: "F = F_model + mass·(a₂ − a), a₂ = (2ζωs + ω²)/(s² + 2ζωs + ω²)·a, ω = 2π·frequency, ζ = damping",
        shows: "a mass that rises with frequency; nothing on one sine",
        confused_with: "time_skew, a filter on the position",
        told_apart_by: "a chirp, a pulse",
        gains: &[Parameter::gain("mass", Dimension::MASS, (0.0, 1e6), "mass of the load")],
        shape: &[
            Parameter::shape(
                "frequency",
                Scale::Frequency,
                (0.1, 1e4),
                "at which the load would swing with the drive held",
            ),
            Parameter::shape("damping", Scale::Damping, (0.02, 0.6), "damping ratio ζ of that"),
        ],
        reads: &[Quantity::Acceleration, Quantity::Time],
        seat: Seat::Drive,
        acts: Acts::Behind,
        ..About::EFFECT
    };
}

#[cfg(feature = "alloc")]
mod operator {
    use super::Compliance;
    use crate::effects::series::{Operator, Record, difference};
    use alloc::vec::Vec;
    use core::f64::consts::TAU;

    /// Acceleration of a load that hangs on a driven body by a spring and a damper, from that body's acceleration `drive`
    /// (m/s²): a₂ = (2ζωs + ω²)/(s² + 2ζωs + ω²)·a with ω = 2π·`frequency` (Hz), at which the load would swing with the
    /// drive held, and the damping ratio ζ. Trapezoidal rule, started in step.
    fn load_on_spring(drive: &[f64], frequency: f64, damping: f64, dt: f64) -> Vec<f64> {
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

    impl Operator for Compliance {
        fn added(_gain: usize, &[frequency, damping]: &[f64; 2], record: &Record<'_>) -> Vec<f64> {
            let load = load_on_spring(record.acceleration, frequency, damping, record.dt);
            difference(&load, record.acceleration)
        }
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
                std::println!("{f} Hz: {peak:.4}, closed form {expected:.4}");
                assert!((peak / expected - 1.0).abs() < 5e-3);
            }
        }
    }
}
