//! Results of validation: refused with the number that would be accepted, or accepted with a warning.

use crate::number::Text;
use core::fmt;
use friction::effects::EffectName;
use friction::{Dimension, Geometry};

/// Accepted values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Accepted {
    /// At most this value.
    AtMost(f32),
    /// At least this value.
    AtLeast(f32),
    /// From the first to the second value.
    Between(f32, f32),
}

impl fmt::Display for Accepted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtMost(high) => write!(f, "accepted up to {}", Text(*high)),
            Self::AtLeast(low) => write!(f, "accepted from {}", Text(*low)),
            Self::Between(low, high) => write!(f, "accepted from {} to {}", Text(*low), Text(*high)),
        }
    }
}

/// Reason of a verdict, with the dimension of its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reason {
    /// Dimension of the value and of the accepted values, if they have one.
    pub dimension: Option<Dimension>,
    /// Whether these are per volt at the pin.
    pub per_volt: bool,
    /// In a few words. Empty if the accepted values say all.
    pub words: &'static str,
}

impl Reason {
    /// Numbers with a dimension.
    pub(crate) const fn of(dimension: Dimension, words: &'static str) -> Self {
        Self { dimension: Some(dimension), per_volt: false, words }
    }

    /// Numbers per volt.
    pub(crate) const fn per_volt(dimension: Dimension, words: &'static str) -> Self {
        Self { per_volt: true, ..Self::of(dimension, words) }
    }

    /// Numbers whose unit goes without saying.
    pub(crate) const fn plain(words: &'static str) -> Self {
        Self { dimension: None, per_volt: false, words }
    }

    /// The same with the unit of this geometry.
    #[must_use]
    pub const fn on(&self, geometry: Geometry) -> On<'_, Self> {
        On(self, geometry)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.on(Geometry::Linear).fmt(f)
    }
}

impl fmt::Display for On<'_, Reason> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Reason { dimension, per_volt, words }, geometry) = self;
        if let Some(dimension) = dimension {
            let volt = if *per_volt { "/V" } else { "" };
            let stop = if words.is_empty() { "" } else { "; " };
            write!(f, "{}{volt}{stop}", dimension.unit(*geometry))?;
        }
        f.write_str(words)
    }
}

/// A refused set of parameters. Prints one line with the parameter, its value and the accepted values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refused {
    /// Effect of the parameter, if any.
    pub effect: Option<EffectName>,
    /// Name of the parameter as a user types it.
    pub parameter: &'static str,
    /// Refused value.
    pub value: f32,
    /// Accepted values, with all other parameters unchanged.
    pub accepted: Accepted,
    /// Reason.
    pub why: Reason,
}

impl Refused {
    /// The same in the units of a device of this geometry.
    #[must_use]
    pub fn on(&self, geometry: Geometry) -> On<'_, Self> {
        On(self, geometry)
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.on(Geometry::Linear).fmt(f)
    }
}

impl fmt::Display for On<'_, Refused> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Refused { effect, parameter, value, accepted, why }, geometry) = self;
        if let Some(effect) = effect {
            write!(f, "{effect}.")?;
        }
        write!(f, "{parameter} = {}: {accepted}; {}", Text(*value), why.on(*geometry))
    }
}

/// A verdict in the units of a device.
#[derive(Debug, Clone, Copy)]
pub struct On<'a, T>(&'a T, Geometry);

impl core::error::Error for Refused {}

/// Warning for an accepted set of parameters that is safe but not faithful.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warning {
    /// Name of the parameter as a user types it.
    pub parameter: &'static str,
    /// Value.
    pub value: f32,
    /// Faithful values, with all other parameters unchanged.
    pub faithful: Accepted,
    /// Reason.
    pub why: Reason,
}

impl Warning {
    /// The same in the units of a device of this geometry.
    #[must_use]
    pub fn on(&self, geometry: Geometry) -> On<'_, Self> {
        On(self, geometry)
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.on(Geometry::Linear).fmt(f)
    }
}

impl fmt::Display for On<'_, Warning> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Warning { parameter, value, faithful, why }, geometry) = self;
        let (word, bound) = match faithful {
            Accepted::AtMost(high) => ("up to", high),
            Accepted::AtLeast(low) | Accepted::Between(low, _) => ("from", low),
        };
        write!(f, "{parameter} = {}: faithful {word} {}; {}", Text(*value), Text(*bound), why.on(*geometry))
    }
}
