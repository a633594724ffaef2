//! Where velocity and acceleration are best taken from: each column there is, or the position.

use crate::calibrate::{Line, filter_variance_gain};
use crate::cutoff::{four_point_gain, white_gain};
use crate::noise::noise_variance;
use crate::stretches::Stretch;
use crate::{Filter, four_point_difference, zero_phase};

/// A velocity column is the derivative of the position, to 2 %.
pub(crate) fn agrees(stretch: &Stretch, position: &[f64], velocity: &[f64], cutoff: f64) -> bool {
    let dt = stretch.dt;
    let Ok(filter) = Filter::butterworth(4, (2.0 * cutoff).min(0.2 / dt), dt) else { return false };
    let given = zero_phase(&filter, &stretch.grid(velocity));
    let derived = four_point_difference(&zero_phase(&filter, &stretch.grid(position)), dt);
    let trim = filter.settle().min(given.len() / 8);
    let inner = trim..given.len() - trim;
    let noise = noise_variance(velocity) * filter_variance_gain(&filter);
    Line::through(&given[inner.clone()], &derived[inner], noise)
        .is_some_and(|line| (line.slope - 1.0).abs() < 0.02 && line.r_squared > 0.98)
}

/// Where velocity or acceleration comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    Position,
    Velocity,
    /// The accelerometer.
    Column,
}

impl Source {
    pub fn words(self, measured: &str) -> &str {
        match self {
            Self::Position => "derived from the position by four-point differences",
            Self::Velocity => "from the velocity column",
            Self::Column => measured,
        }
    }
}

/// Variance of the white noise of each channel.
pub(crate) struct Sources {
    /// s.
    pub dt: f64,
    pub position: f64,
    pub velocity: Option<f64>,
    pub acceleration: Option<f64>,
}

impl Sources {
    pub fn of_velocity(&self, source: Source, filter: impl Fn(f64) -> f64) -> f64 {
        match source {
            Source::Velocity => self.velocity.unwrap_or(0.0) * white_gain(filter),
            _ => self.position * white_gain(|f| filter(f) * four_point_gain(f, self.dt)),
        }
    }

    pub fn of_acceleration(&self, source: Source, filter: impl Fn(f64) -> f64) -> f64 {
        let slope = |f| four_point_gain(f, self.dt);
        match source {
            Source::Column => self.acceleration.unwrap_or(0.0) * white_gain(filter),
            Source::Velocity => self.velocity.unwrap_or(0.0) * white_gain(|f| filter(f) * slope(f)),
            Source::Position => self.position * white_gain(|f| filter(f) * slope(f).powi(2)),
        }
    }

    /// The source with the smallest error behind the filter, and its variance.
    pub fn velocity(&self, filter: &Filter) -> (f64, Source) {
        let error = |s| self.of_velocity(s, |f| filter.gain(f).powi(2));
        let derived = (error(Source::Position), Source::Position);
        match self.velocity {
            Some(_) if error(Source::Velocity) < derived.0 => (error(Source::Velocity), Source::Velocity),
            _ => derived,
        }
    }

    pub fn acceleration(&self, filter: &Filter) -> (f64, Source) {
        let error = |s| self.of_acceleration(s, |f| filter.gain(f).powi(2));
        let mut best = (error(Source::Position), Source::Position);
        for (source, there) in
            [(Source::Velocity, self.velocity.is_some()), (Source::Column, self.acceleration.is_some())]
        {
            let variance = error(source);
            if there && variance < best.0 {
                best = (variance, source);
            }
        }
        best
    }
}
