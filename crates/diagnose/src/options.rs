//! What a caller may decide, and what can go wrong.

use crate::experiment::moves::Limits;
use crate::per_recording::Nuisance;
use std::fmt;
use std::ops::ControlFlow;

/// Choices of a diagnosis; the default is right for most recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Standard deviation of one raw force sample, N or N·m, where the user knows it.
    pub declared_noise: Option<f64>,
    /// Cut-off of the zero-phase filter, Hz; chosen from the channels' noise when absent.
    pub cutoff_hz: Option<f64>,
    /// Seed of every random draw: the same seed gives the same diagnosis.
    pub seed: u64,
    /// Most effects to name.
    pub max_terms: usize,
    /// Hypotheses carried along in the search.
    pub beam_width: usize,
    /// Effects not to be considered, by id.
    pub exclude: Vec<String>,
    /// What differs between recordings; everything else is shared.
    pub per_recording: Vec<Nuisance>,
    /// Position is zero at the same place in every recording: the encoder is absolute, or was homed.
    pub absolute: bool,
    /// What the device that makes the next move can do; what the recordings show when absent.
    pub limits: Option<Limits>,
    /// Open questions, an effect and its rival if it has one, that no more moves are to be made for.
    pub given_up: Vec<(String, Option<String>)>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            declared_noise: None,
            cutoff_hz: None,
            seed: 1,
            max_terms: 8,
            beam_width: 3,
            exclude: Vec::new(),
            per_recording: Vec::new(),
            absolute: false,
            limits: None,
            given_up: Vec::new(),
        }
    }
}

/// Largest number of a recording, in its unit: a fourth power of it is a number still.
pub(crate) const LARGEST: f64 = 1e50;

/// Input that cannot be diagnosed. A recording from which nothing can be concluded is accepted: its verdict is `not_testable`.
#[derive(Debug, Clone, PartialEq)]
pub enum Error {
    /// No recording was given.
    NoRecording,
    /// A recording that cannot be prepared.
    Recording(signals::Error),
    /// Recordings of a slide and of an axis cannot share parameters.
    MixedGeometry {
        /// Name of the first recording that differs.
        name: String,
    },
    /// Some recordings have a normal force, others not.
    MixedNormalForce {
        /// Name of the first recording without it.
        name: String,
        /// Name of one that has it.
        other: String,
    },
    /// Channels of one recording have different lengths.
    Length {
        /// Name of the recording.
        name: String,
        /// Channel.
        channel: &'static str,
        /// Its length.
        found: usize,
        /// The length of its time.
        expected: usize,
    },
    /// A number whose square, or that of its product with others, is none any more.
    TooLarge {
        /// Name of the recording.
        name: String,
        /// Channel.
        channel: &'static str,
        /// When, s.
        at: f64,
        /// The value.
        value: f64,
    },
    /// Whoever watches asked for an early end.
    Interrupted,
    /// An option outside what is accepted.
    Option {
        /// Name.
        name: &'static str,
        /// The value that was refused.
        value: f64,
        /// What is accepted.
        accepted: &'static str,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRecording => write!(f, "no recording to diagnose: give at least one"),
            Self::Recording(error) => error.fmt(f),
            Self::MixedGeometry { name } => {
                write!(f, "{name}: linear and rotary recordings cannot be diagnosed together")
            }
            Self::MixedNormalForce { name, other } => write!(
                f,
                "{name}: no normal_force_n, and {other} has it: friction that grows with the load needs it in every recording, or in none"
            ),
            Self::Length { name, channel, found, expected } => {
                write!(f, "{name}: {channel} has {found} samples, time has {expected}: they must agree")
            }
            Self::TooLarge { name, channel, at, value } => write!(
                f,
                "{name}: {channel} at {at} s is {value:.3e}: accepted up to {LARGEST:e} in size; is the unit right?"
            ),
            Self::Interrupted => write!(f, "interrupted"),
            Self::Option { name, value, accepted } => write!(f, "{name} = {value}: accepted {accepted}"),
        }
    }
}

impl std::error::Error for Error {}

impl From<signals::Error> for Error {
    fn from(error: signals::Error) -> Self {
        Self::Recording(error)
    }
}

/// Told a share of the work done and what is being done; `Break` ends the diagnosis.
pub(crate) type Watch<'a> = &'a dyn Fn(f32, &str) -> ControlFlow<()>;

/// A watch asked for an early end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Interrupted;

impl From<Interrupted> for Error {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// Tells the watch, and hears whether to go on.
pub(crate) fn tell(watch: Watch<'_>, share: f32, what: &str) -> Result<(), Interrupted> {
    match watch(share, what) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Interrupted),
    }
}

impl Options {
    /// Checks the options.
    ///
    /// # Errors
    /// The first option outside its range.
    pub fn validate(&self) -> Result<(), Error> {
        let positive = |name, value: Option<f64>| match value {
            Some(v) if !(v.is_finite() && v > 0.0) => {
                Err(Error::Option { name, value: v, accepted: "a finite number above 0" })
            }
            _ => Ok(()),
        };
        positive("declared_noise", self.declared_noise)?;
        positive("cutoff_hz", self.cutoff_hz)?;
        if !(1..=8).contains(&self.max_terms) {
            return Err(Error::Option {
                name: "max_terms",
                value: self.max_terms as f64,
                accepted: "1 to 8",
            });
        }
        if !(1..=8).contains(&self.beam_width) {
            return Err(Error::Option {
                name: "beam_width",
                value: self.beam_width as f64,
                accepted: "1 to 8",
            });
        }
        Ok(())
    }
}
