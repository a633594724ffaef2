//! What validation answers: refused with the number that would be accepted, or taken with a warning.

use crate::number::Text;
use core::fmt;

/// The values that would be accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Accepted {
    /// Up to and including this.
    AtMost(f32),
    /// From this on.
    AtLeast(f32),
    /// From the first to the second.
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

/// A set of parameters that must not run. One line names the parameter, its value and what is accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refused {
    /// Effect the parameter belongs to, if any.
    pub effect: Option<&'static str>,
    /// Name of the parameter as a user types it.
    pub parameter: &'static str,
    /// Value that was refused.
    pub value: f32,
    /// What would be accepted, everything else unchanged.
    pub accepted: Accepted,
    /// The reason, in a few words.
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

/// A set of parameters that is safe but will not feel as asked. It is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warning {
    /// Name of the parameter as a user types it.
    pub parameter: &'static str,
    /// Its value.
    pub value: f32,
    /// What would be faithful, everything else unchanged.
    pub faithful: Accepted,
    /// The reason, in a few words.
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
