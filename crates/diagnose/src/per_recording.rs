//! What may differ from one recording to the next without being physics.

use friction::effects::Parameter;
use friction::parameters::{FRICTION, OFFSET, ORIGIN};
use serde::Serialize;

/// What may be declared to differ between recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nuisance {
    /// A constant that the force channel adds.
    Offset,
    /// Where position is zero.
    Origin,
    /// The Coulomb level, by as much in both directions.
    Friction,
}

impl Nuisance {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::Offset, Self::Origin, Self::Friction];

    /// As typed and in files.
    #[must_use]
    pub fn id(self) -> &'static str {
        self.parameter().name
    }

    /// What it measures.
    pub(crate) fn parameter(self) -> &'static Parameter {
        match self {
            Self::Offset => &OFFSET,
            Self::Origin => &ORIGIN,
            Self::Friction => &FRICTION,
        }
    }

    /// The nuisance of this name.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|n| n.id() == id)
    }

    /// Its column on a track, where it is one.
    pub(crate) fn column(self, sign: &[f64]) -> Option<Vec<f64>> {
        match self {
            Self::Offset => Some(vec![1.0; sign.len()]),
            Self::Friction => Some(sign.to_vec()),
            Self::Origin => None,
        }
    }
}

/// A nuisance of one recording: what it has beyond the first one, or, where a frozen model is judged, beyond the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PerRecording {
    /// Name of the recording.
    pub recording: String,
    /// `offset`, `origin` or `friction`.
    pub nuisance: String,
    /// Estimate; 0 where the recordings do not determine it.
    pub value: f64,
    /// Standard deviation; NaN (null) where the recordings do not determine it.
    pub std: f64,
    /// SI unit.
    pub unit: String,
}
