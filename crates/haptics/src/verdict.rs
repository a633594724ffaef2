//! Results of validation: refused with the number that would be accepted, or accepted with a warning.

use crate::number::Text;
use core::fmt;

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

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(effect) = self.effect {
            write!(f, "{effect}.")?;
        }
        write!(f, "{} = {}: {}; {}", self.parameter, Text(self.value), self.accepted, self.why)
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

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let faithful = match self.faithful {
            Accepted::AtMost(high) => {
                let high = Text(high);
                return write!(
                    f,
                    "{} = {}: faithful up to {high}; {}",
                    self.parameter,
                    Text(self.value),
                    self.why
                );
            }
            Accepted::AtLeast(low) | Accepted::Between(low, _) => Text(low),
        };
        write!(f, "{} = {}: faithful from {faithful}; {}", self.parameter, Text(self.value), self.why)
    }
}
