//! What keeps two recordings from being compared.

/// Rows of steady sliding a direction needs, and a bin of speed.
pub(crate) const FEWEST: usize = 40;

/// Recordings that cannot be compared.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A recording cannot be prepared or identified.
    #[error(transparent)]
    Recording(#[from] signals::Error),
    /// A recording of an axis.
    #[error("{0}: is of an axis, in N·m; just noticeable differences are known in N at a handle")]
    Rotary(String),
    /// A recording without steady sliding.
    #[error(
        "{recording}: {samples} samples of steady sliding in {direction} direction; {FEWEST} are accepted"
    )]
    NoSliding {
        /// Which.
        recording: String,
        /// How many there are.
        samples: usize,
        /// `forward` or `reverse`.
        direction: &'static str,
    },
    /// The recordings have no speed in common.
    #[error("no speed at which all slide: {0}")]
    NoCommonSpeed(String),
    /// A recording in the plane that slides in too few directions.
    #[error("{recording}: slides in {visited} of 8 sectors of a half turn; 5 are accepted")]
    FewDirections {
        /// Which.
        recording: String,
        /// Number of sectors.
        visited: usize,
    },
    /// No recording among what is compared in the plane.
    #[error("two models in the plane have no speed to be compared at")]
    ModelsOnly,
    /// Inertia and friction are collinear.
    #[error("{0}: the motion does not tell inertia and friction apart")]
    Collinear(String),
}

impl Error {
    /// What would be accepted.
    #[must_use]
    pub fn help(&self) -> Option<&'static str> {
        match self {
            Self::Rotary(_) => Some("recordings with position_m and force_n are accepted"),
            Self::NoSliding { .. } => {
                Some("move to and fro, over several millimetres, for ten seconds or more")
            }
            Self::NoCommonSpeed(_) => Some("recordings whose speeds overlap are accepted"),
            Self::FewDirections { .. } => Some("move in circles, or along lines in several directions"),
            Self::ModelsOnly => Some("a recording and a model are accepted, and two recordings"),
            Self::Collinear(_) => {
                Some("a motion whose speed changes is accepted, such as a hand that moves to and fro")
            }
            Self::Recording(_) => None,
        }
    }
}
