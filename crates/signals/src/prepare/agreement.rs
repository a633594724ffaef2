//! Do the motion channels belong to one motion? A velocity or an acceleration channel that is behind the position, and one with
//! another scale or zero, show when channels are compared. That needs no force.
//!
//! A column is fitted by the position's derivatives over all stretches of a recording together:
//! v_column = scale·(v − lag·a) + zero, a_column = scale·(a − lag·da/dt) + zero.

use super::channels::Channels;
use super::cutoff::differentiated;
use crate::{LowPass, four_point_difference, noise_std};
use nalgebra::{Matrix3, Vector3};

/// A column compared with what the position says.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Column {
    /// Times what the position says, and its standard deviation.
    pub scale: (f64, f64),
    /// How late, s.
    pub lag: (f64, f64),
    /// What it shows at zero.
    pub zero: (f64, f64),
    /// Share of its power that is neither the motion nor its own white noise.
    pub unexplained: f64,
}

/// Velocity and acceleration column of the stretches of one recording against its position; stretches over which the
/// filter does not settle are used only where there is no other.
pub(super) fn compare(stretches: &[Channels]) -> (Option<Column>, Option<Column>) {
    let mut velocity = Sums::default();
    let mut acceleration = Sums::default();
    let filters: Vec<LowPass> = stretches
        .iter()
        .map(|c| LowPass::new((4.0 * c.dominant_frequency()).clamp(1e-3 / c.dt, 0.1 / c.dt), c.dt))
        .collect();
    let settles = |(c, filter): &(&Channels, &LowPass)| c.len() >= 4 * filter.settle();
    let any = stretches.iter().zip(&filters).any(|part| settles(&part));
    for (c, filter) in stretches.iter().zip(&filters).filter(|part| !any || settles(part)) {
        let n = c.len();
        let settle = filter.settle().min(n / 4);
        let v = four_point_difference(&filter.apply(&c.position), c.dt);
        let a = four_point_difference(&v, c.dt);
        let behind = |series: &[f64], order| noise_std(series) * differentiated(order, filter.cutoff(), c.dt);
        let independent = 2.0 * filter.cutoff() * c.dt;
        if let Some(column) = &c.velocity {
            velocity.noise(n - 2 * settle, behind(&c.position, 1), behind(column, 0));
            let column = filter.apply(column);
            for i in settle..n - settle {
                velocity.add([v[i], -a[i], 1.0], column[i], independent);
            }
        }
        if let Some(column) = &c.acceleration {
            acceleration.noise(n - 2 * settle, behind(&c.position, 2), behind(column, 0));
            let column = filter.apply(column);
            let jerk = four_point_difference(&a, c.dt);
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
    /// Squared noise in the first regressor, and in the column.
    of_position: f64,
    of_column: f64,
}

impl Sums {
    fn add(&mut self, row: [f64; 3], y: f64, independent: f64) {
        let row = Vector3::from(row);
        self.gram += row * row.transpose();
        self.moment += row * y;
        self.power += y * y;
        self.independent += independent;
    }

    fn noise(&mut self, rows: usize, of_position: f64, of_column: f64) {
        self.of_position += rows as f64 * of_position * of_position;
        self.of_column += rows as f64 * of_column * of_column;
    }

    fn solve(&self) -> Option<Column> {
        let mut gram = self.gram;
        // the position's noise would scale the column up [fuller-1987]
        gram[(0, 0)] -= self.of_position.min(0.5 * gram[(0, 0)]);
        // scaled to a unit diagonal: the three have different units
        let scale = gram.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
        let unit = Matrix3::from_fn(|i, j| gram[(i, j)] * scale[i] * scale[j]);
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
            unexplained: (left - self.of_column).max(0.0) / self.power,
        })
    }
}

impl Column {
    /// The column is the derivative of the position to 2 % and 7 % of its size, its own white noise apart.
    #[must_use]
    pub fn is_the_derivative(&self) -> bool {
        (self.scale.0 - 1.0).abs() < 0.02 && self.unexplained < 0.005
    }

    /// The column follows the second derivative of the position, in some scale between 0.2 and 5.
    #[must_use]
    pub fn follows(&self) -> bool {
        self.unexplained < 0.1 && self.scale.0 > 0.2 && self.scale.0 < 5.0
    }

    /// Scale or zero differ from the position's by more than chance: a smaller correction would only add its own error.
    #[must_use]
    pub fn differs(&self) -> bool {
        (self.scale.0 - 1.0).abs() > 5.0 * self.scale.1 || self.zero.0.abs() > 5.0 * self.zero.1
    }

    /// Scale or zero are off by more than chance and three percent: a fault of the recording.
    #[must_use]
    pub fn is_off(&self) -> bool {
        let (zero, std) = self.zero;
        (self.scale.0 - 1.0).abs() > (5.0 * self.scale.1).max(0.03) || zero.abs() > 8.0 * std
    }

    /// The lag, s, where the column is later than `least` seconds by more than chance. Of eight runs of 2 s, one was mended by
    /// chance and disagreed with the others.
    #[must_use]
    pub fn late(&self, least: f64) -> Option<f64> {
        let (lag, std) = self.lag;
        (lag > least + 5.0 * std).then_some(lag)
    }

    /// A backward difference of the position is late by half a sample: how a column was made, not an estimator's lag.
    #[must_use]
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
            assert!(found.is_the_derivative());
            assert!((found.lag.0 - lag).abs() < 2e-5 && (found.scale.0 - 1.0).abs() < 5e-3);
            assert_eq!(found.late(1e-4).is_some(), lag > 1e-4);
            assert_eq!(found.is_backward_difference(1e-3), lag == 0.5e-3);
        }
    }

    /// A first order of 1 ms, as accelerometers have in front of their converter; the force looked as late as that.
    #[test]
    fn an_acceleration_behind_its_own_low_pass_is_told_with_its_lag() {
        let mut channels = channels(0.0);
        let (w, lag) = (12.0, 1e-3);
        let shown = |w: f64, t: f64| ((w * t).sin() - w * lag * (w * t).cos()) / (1.0 + (w * lag).powi(2));
        let at = |i: i32| f64::from(i) * channels.dt;
        let acceleration =
            |i: i32| -0.01 * (w * w * shown(w, at(i)) + 0.3 * (2.6 * w).powi(2) * shown(2.6 * w, at(i)));
        channels.acceleration = Some((0..8000).map(acceleration).collect());
        let found = compare(&[channels]).1.unwrap();
        println!("{found:?}");
        assert!(found.follows() && (found.lag.0 - lag).abs() < 3e-5, "{found:?}");
        assert!(found.late(0.75e-3).is_some() && !found.is_off());
    }
}
