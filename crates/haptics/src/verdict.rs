//! Results of validation: refused with the number that would be accepted, or accepted with a warning.

use crate::number::Text;
use core::fmt;
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

/// A refused set of parameters. Prints one line with the parameter, its value and the accepted values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refused {
    /// Effect of the parameter, if any.
    pub effect: Option<&'static str>,
    /// Name of the parameter as a user types it.
    pub parameter: &'static str,
    /// Refused value.
    pub value: f32,
    /// Accepted values, with all other parameters unchanged.
    pub accepted: Accepted,
    /// Reason in a few words.
    pub why: &'static str,
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
        write!(f, "{parameter} = {}: {accepted}; ", Text(*value))?;
        reason(why, *geometry, f)
    }
}

/// A verdict in the units of a device.
#[derive(Debug, Clone, Copy)]
pub struct On<'a, T>(&'a T, Geometry);

/// Units that a reason begins with.
const UNITS: &[(&str, Dimension)] = &[
    ("N", Dimension::FORCE),
    ("m", Dimension::LENGTH),
    ("m/s", Dimension::VELOCITY),
    ("m/s2", Dimension::ACCELERATION),
    ("kg", Dimension::MASS),
    ("N/m", Dimension::STIFFNESS),
    ("N·s/m", Dimension::DAMPING),
];

/// A reason with the unit it begins with, if any, as that of this geometry.
fn reason(why: &str, geometry: Geometry, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    // by bytes: a search for a character takes 2 kB of flash
    let at = why.bytes().position(|byte| byte == b';').unwrap_or(why.len());
    let (unit, rest) = why.split_at_checked(at).unwrap_or((why, ""));
    let (bare, per_volt) = unit.strip_suffix("/V").map_or((unit, ""), |bare| (bare, "/V"));
    match UNITS.iter().find(|(text, _)| *text == bare && geometry == Geometry::Rotary) {
        Some((_, dimension)) => write!(f, "{}{per_volt}{rest}", dimension.unit(geometry)),
        None => f.write_str(why),
    }
}

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
    /// Reason in a few words.
    pub why: &'static str,
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
        write!(f, "{parameter} = {}: faithful {word} {}; ", Text(*value), Text(*bound))?;
        reason(why, *geometry, f)
    }
}
