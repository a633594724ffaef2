//! Faults of a recording, found before anything is fitted so that they are not taken for physics.

mod agreement;
mod channels;
mod clock;
mod fault;
mod jumps;
mod outliers;
mod plausible;
mod spectrum;

pub use clock::regressed;
pub use fault::{FaultKind, RecordingFault};
pub use jumps::{Jump, jumps};
pub use outliers::without_outliers;
pub use plausible::implausible_mass;

use crate::Recording;
use crate::stretches::{cut, used};
use serde::{Deserialize, Serialize};

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
    clock::stamped_by_a_host(recording, dt, &mut out.faults);
    clock::declared(recording, dt, &mut out.faults);
    channels::values(recording, &mut out.faults);
    channels::motion(recording, &mut out.faults);
    outliers::far_from_neighbours(recording, &mut out.faults);
    plausible::units(recording, dt, &mut out.faults);
    let stretches = cut(&recording.time, &used(recording), dt);
    jumps::report(recording, &stretches, &mut out.faults);
    if let Some(longest) = stretches.iter().max_by_key(|s| s.range.len()) {
        agreement::check(recording, longest, &mut out.faults);
        spectrum::hidden_filter(recording, longest, &mut out.faults);
    }
    out
}
