//! The force that acts on the body, as far as it is known: what stands for "the applied force" inside a regressor, because
//! the measured force's own noise there would correlate with itself.
//!
//! At first that is the baseline. What moves, distorts or follows the force is then found with a force from which it
//! still bends the mass and the friction, so that its size is wrong by the square of what it does; once the rest is
//! known the force is taken from all of it.

use crate::library::baseline::Physics;
use friction::effects::{EffectKind, MAX_GAINS, MAX_SHAPE};

/// Coefficients of the baseline, and the forces beyond it.
#[derive(Debug, Clone, Default)]
pub struct AppliedForce {
    /// Baseline.
    pub baseline: Physics,
    /// Effects with gains and shape.
    pub effects: Vec<(EffectKind, [f64; MAX_GAINS], [f64; MAX_SHAPE])>,
}

impl AppliedForce {
    /// The baseline alone.
    pub fn baseline(baseline: Physics) -> Self {
        Self { baseline, effects: Vec::new() }
    }
}
