//! A channel of a recording as an observation of the motion.

use crate::{Error, noise_variance, quantum};

/// Quantity that a channel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Observed {
    /// m or rad.
    Position,
    /// m/s or rad/s.
    Velocity,
    /// m/s² or rad/s².
    Acceleration,
}

impl Observed {
    /// Component of the state, which is also the number of differentiations.
    pub(super) fn component(self) -> usize {
        match self {
            Self::Position => 0,
            Self::Velocity => 1,
            Self::Acceleration => 2,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
        }
    }
}

/// A channel: value(t) = scale · quantity(t − lag) + zero + noise.
///
/// Values that are not finite count as missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation<'a> {
    /// Quantity observed.
    pub observed: Observed,
    /// One value for each stamp.
    pub values: &'a [f64],
    /// Standard deviation of the white noise of a value, in the unit of the channel.
    pub std: f64,
    /// Step between two codes of the channel, 0 where it is continuous. Its noise counts as at least quantum/√12.
    pub quantum: f64,
    /// Time by which the channel is behind its stamps, s.
    pub lag: f64,
    /// Reading for one unit of the quantity.
    pub scale: f64,
    /// Reading for a quantity of zero.
    pub zero: f64,
}

impl<'a> Observation<'a> {
    /// A channel of unit scale without lag; noise and quantum are estimated from its values.
    #[must_use]
    pub fn new(observed: Observed, values: &'a [f64]) -> Self {
        Self {
            observed,
            values,
            std: noise_variance(values).sqrt(),
            quantum: quantum(values),
            lag: 0.0,
            scale: 1.0,
            zero: 0.0,
        }
    }

    /// Variance of one reading as an observation of the quantity itself: of noise and rounding, and never below what the
    /// representation of its values resolves.
    pub(super) fn variance(&self) -> f64 {
        let finite = self.values.iter().copied().filter(|x| x.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let span = if low <= high { high - low } else { 0.0 };
        let resolved = (1e-9 * span).max(4.0 * f64::EPSILON * low.abs().max(high.abs())).max(1e-120);
        let resolved = if resolved.is_finite() { resolved } else { 1e-120 };
        let std = self.std.max(self.quantum / 12f64.sqrt()).max(resolved);
        (std / self.scale).powi(2)
    }

    /// The quantity that reading `i` shows, where there is one.
    pub(super) fn quantity(&self, i: usize) -> Option<f64> {
        let value = *self.values.get(i)?;
        value.is_finite().then(|| (value - self.zero) / self.scale)
    }

    pub(super) fn validate(&self, stamps: usize) -> Result<(), Error> {
        let refuse = |parameter: &str, value: String, accepted: String| {
            let parameter = format!("{} of the {} channel", parameter, self.observed.name());
            Err(Error::Parameter { parameter, value, accepted })
        };
        if self.values.len() != stamps {
            let accepted = format!("accepted is one for each of the {stamps} stamps");
            return refuse("values", self.values.len().to_string(), accepted);
        }
        for (name, value) in [("std", self.std), ("quantum", self.quantum)] {
            if !(value >= 0.0 && value.is_finite()) {
                return refuse(name, value.to_string(), "accepted are finite values from 0".into());
            }
        }
        for (name, value) in [("lag", self.lag), ("zero", self.zero)] {
            if !value.is_finite() {
                return refuse(name, value.to_string(), "accepted are finite values".into());
            }
        }
        if !(self.scale.is_finite() && self.scale != 0.0) {
            return refuse("scale", self.scale.to_string(), "accepted are finite values except 0".into());
        }
        Ok(())
    }
}
