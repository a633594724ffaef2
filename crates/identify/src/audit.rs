//! What is wrong with a recording, found before anything is fitted: faults of the recording, not physics.

mod agreement;
mod channels;
mod clock;
mod outliers;
mod plausible;
mod spectrum;

pub use outliers::without_outliers;

use crate::Recording;
use crate::stretches::{cut, used};
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

/// Looks for faults of the recording. Silent where there are none: what is physics is not reported here.
#[must_use]
pub fn audit(recording: &Recording) -> Audit {
    let mut out =
        Audit { samples: recording.len(), sample_period: recording.sample_period(), ..Audit::default() };
    if let Err(error) = recording.check_lengths() {
        out.faults.push(RecordingFault::new(FaultKind::TooShort, None, error.to_string()));
        return out;
    }
    if recording.len() < crate::stretches::SHORTEST {
        let why = format!("{} samples, at least {} are needed", recording.len(), crate::stretches::SHORTEST);
        out.faults.push(RecordingFault::new(FaultKind::TooShort, None, why));
    }
    clock::not_a_number(recording, &mut out.faults);
    let Some(dt) = out.sample_period else {
        if recording.len() > 1 {
            let why = "time never goes forward: no sampling period can be told".to_string();
            out.faults.push(RecordingFault::new(FaultKind::ClockBackward, None, why));
        }
        return out;
    };
    clock::steps(recording, dt, &mut out.faults);
    clock::declared(recording, dt, &mut out.faults);
    channels::values(recording, &mut out.faults);
    channels::motion(recording, &mut out.faults);
    outliers::far_from_neighbours(recording, &mut out.faults);
    plausible::units(recording, dt, &mut out.faults);
    let stretches = cut(&recording.time, &used(recording), dt);
    if let Some(longest) = stretches.iter().max_by_key(|s| s.range.len()) {
        clock::renumbered(recording, longest, &mut out.faults);
        agreement::check(recording, longest, &mut out.faults);
        spectrum::hidden_filter(recording, longest, &mut out.faults);
    }
    out
}
