//! A fault of a recording.

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
    /// The position jumps, and neither a motion nor lost samples explain it.
    PositionJump,
    /// The clock contradicts the rate that the metadata or another channel gives.
    TimeBase,
    /// The velocity column is a multiple of the derivative of the position.
    VelocityScale,
    /// The velocity column is not the derivative of the position.
    VelocityMismatch,
    /// The acceleration column has another scale or zero than the second derivative of the position.
    AccelerationScale,
    /// The position carries a wave that an independent velocity or acceleration column does not show.
    EncoderWave,
    /// The zero of the force channel drifts.
    ForceDrift,
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
    /// The body reverses every few samples.
    QuickReversals,
    /// Samples far from all their neighbours.
    Outliers,
    /// The force, or the speed, jumps between two samples.
    UnresolvedBlow,
    /// Numbers that no bench of this kind gives: another unit than the header says, or the wrong sign.
    Implausible,
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

impl RecordingFault {
    /// A fault of this kind, at a time to the nanosecond.
    #[must_use]
    pub fn new(kind: FaultKind, at_s: Option<f64>, why: String) -> Self {
        // To the nanosecond: a sum of periods has rounding in its last places.
        let at_s =
            at_s.filter(|t| t.is_finite()).map(|t| if t.abs() < 1e6 { (t * 1e9).round() / 1e9 } else { t });
        Self { kind, at_s, why }
    }
}
