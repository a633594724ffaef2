//! The best source of velocity and acceleration: a column of the recording, or the position.

use crate::LowPass;
use crate::filter::{four_point_gain, white_gain};

/// Where velocity or acceleration comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// Derivatives of the position.
    Position,
    /// The velocity column.
    Velocity,
    /// The accelerometer.
    Column,
}

impl Source {
    /// The source in words; `measured` stands for the column itself.
    #[must_use]
    pub fn words(self, measured: &str) -> &str {
        match self {
            Self::Position => "derived from the position by four-point differences",
            Self::Velocity => "from the velocity column",
            Self::Column => measured,
        }
    }
}

/// Variance of the white noise of each channel.
pub struct Sources {
    /// s.
    pub dt: f64,
    /// m².
    pub position: f64,
    /// (m/s)².
    pub velocity: Option<f64>,
    /// (m/s²)².
    pub acceleration: Option<f64>,
}

impl Sources {
    /// Variance of the velocity taken from `source` behind a filter with the gain `filter`.
    pub fn of_velocity(&self, source: Source, filter: impl Fn(f64) -> f64) -> f64 {
        match source {
            Source::Velocity => self.velocity.unwrap_or(0.0) * white_gain(filter),
            _ => self.position * white_gain(|f| filter(f) * four_point_gain(f, self.dt)),
        }
    }

    /// Variance of the acceleration taken from `source` behind a filter with the gain `filter`.
    pub fn of_acceleration(&self, source: Source, filter: impl Fn(f64) -> f64) -> f64 {
        let slope = |f| four_point_gain(f, self.dt);
        match source {
            Source::Column => self.acceleration.unwrap_or(0.0) * white_gain(filter),
            Source::Velocity => self.velocity.unwrap_or(0.0) * white_gain(|f| filter(f) * slope(f)),
            Source::Position => self.position * white_gain(|f| filter(f) * slope(f).powi(2)),
        }
    }

    /// The source with the smallest error behind the filter, and its variance.
    pub fn velocity(&self, filter: &LowPass) -> (f64, Source) {
        let error = |s| self.of_velocity(s, |f| filter.gain(f));
        let derived = (error(Source::Position), Source::Position);
        match self.velocity {
            Some(_) if error(Source::Velocity) < derived.0 => (error(Source::Velocity), Source::Velocity),
            _ => derived,
        }
    }

    /// [`Self::velocity`] of the acceleration.
    #[must_use]
    pub fn acceleration(&self, filter: &LowPass) -> (f64, Source) {
        let error = |s| self.of_acceleration(s, |f| filter.gain(f));
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
