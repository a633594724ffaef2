//! Do the motion channels belong to one motion? A velocity channel that is behind the position, and an accelerometer with
//! another scale or zero, are told by comparing channels: no force is needed for that, and none could say it as well.
//!
//! The velocity column is fitted by the position's derivatives, v_column = scale·(v − lag·a) + zero, over all stretches
//! of a recording together; the acceleration column by a_column = scale·a + zero.

use crate::signal::{LowPass, derivative};
use crate::track::{Channels, dominant_frequency};
use nalgebra::{Matrix3, Vector3};

/// What a column says of its channel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Column {
    /// Times what the position says, and its standard deviation.
    pub scale: (f64, f64),
    /// How late, s; of the velocity only.
    pub lag: (f64, f64),
    /// What it shows at zero.
    pub zero: (f64, f64),
}

/// Velocity and acceleration column of the stretches of one recording against its position.
pub fn compare(stretches: &[Channels]) -> (Option<Column>, Option<Column>) {
    let mut velocity = Sums::default();
    let mut acceleration = Sums::default();
    for c in stretches {
        let cutoff = (4.0 * dominant_frequency(c)).clamp(1e-3 / c.dt, 0.1 / c.dt);
        let filter = LowPass::new(cutoff, c.dt);
        let n = c.position.len();
        let settle = filter.settle();
        if n < 4 * settle {
            continue;
        }
        let v = derivative(&filter.apply(&c.position), c.dt);
        let a = derivative(&v, c.dt);
        let independent = 2.0 * cutoff * c.dt;
        if let Some(column) = &c.velocity {
            let column = filter.apply(column);
            for i in settle..n - settle {
                velocity.add([v[i], -a[i], 1.0], column[i], independent);
            }
        }
        if let Some(column) = &c.acceleration {
            let column = filter.apply(column);
            let jerk = derivative(&a, c.dt);
            for i in settle..n - settle {
                acceleration.add([a[i], -jerk[i], 1.0], column[i], independent);
            }
        }
    }
    (velocity.solve(), acceleration.solve())
}

/// Normal equations of three regressors.
#[derive(Default)]
struct Sums {
    gram: Matrix3<f64>,
    moment: Vector3<f64>,
    power: f64,
    independent: f64,
}

impl Sums {
    fn add(&mut self, row: [f64; 3], y: f64, independent: f64) {
        let row = Vector3::from(row);
        self.gram += row * row.transpose();
        self.moment += row * y;
        self.power += y * y;
        self.independent += independent;
    }

    fn solve(&self) -> Option<Column> {
        // scaled to a unit diagonal: the three have different units
        let scale = self.gram.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
        let unit = Matrix3::from_fn(|i, j| self.gram[(i, j)] * scale[i] * scale[j]);
        let inverse = unit.try_inverse()?;
        let cover = Matrix3::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j]);
        let c = cover * self.moment;
        let left = (self.power - c.dot(&self.moment)).max(0.0);
        // samples behind the filter depend on each other: the cover counts all, the residual spreads over the few
        let std = |i: usize| (left / self.independent.max(4.0) * cover[(i, i)].max(0.0)).sqrt();
        let fits = c.iter().all(|x| x.is_finite()) && c[0].abs() > 1e-6 && left < 0.2 * self.power;
        fits.then(|| Column {
            scale: (c[0], std(0)),
            lag: (c[1] / c[0], std(1) / c[0].abs()),
            zero: (c[2], std(2)),
        })
    }
}

impl Column {
    /// The lag, s, and its standard deviation, where the column is late by more than chance and a tenth of a sample.
    pub fn late(&self, dt: f64) -> Option<(f64, f64)> {
        let (lag, std) = self.lag;
        (lag > 5.0 * std && lag > 0.1 * dt).then_some((lag, std))
    }

    /// A backward difference of the position is late by half a sample: how a column was made, not an estimator's lag.
    pub fn is_backward_difference(&self, dt: f64) -> bool {
        (self.lag.0 / dt - 0.5).abs() < 0.03
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channels(lag: f64) -> Channels {
        let dt = 1e-3;
        let w = 12.0;
        let at = |f: fn(f64) -> f64, by: f64, size: f64| -> Vec<f64> {
            (0..8000)
                .map(|i| {
                    size * (f(w * (f64::from(i) * dt - by)) + 0.3 * f(2.6 * w * (f64::from(i) * dt - by)))
                })
                .collect()
        };
        Channels {
            dt,
            position: at(f64::sin, 0.0, 0.01),
            velocity: Some(
                (0..8000)
                    .map(|i| f64::from(i) * dt - lag)
                    .map(|t| 0.01 * w * ((w * t).cos() + 0.3 * 2.6 * (2.6 * w * t).cos()))
                    .collect(),
            ),
            force: at(f64::cos, 0.0, 1.0),
            ..Channels::default()
        }
    }

    #[test]
    fn a_late_velocity_is_told_to_a_tenth_of_a_sample() {
        for lag in [0.0, 0.2e-3, 0.5e-3, 2e-3] {
            let found = compare(&[channels(lag)]).0.unwrap();
            println!("{lag}: {found:?}");
            assert!((found.lag.0 - lag).abs() < 2e-5 && (found.scale.0 - 1.0).abs() < 5e-3);
            assert_eq!(found.late(1e-3).is_some(), lag > 1e-4);
            assert_eq!(found.is_backward_difference(1e-3), lag == 0.5e-3);
        }
    }
}
