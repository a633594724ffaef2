//! The force that acts on the body, modelled. Regressors use it as "the applied force", because noise of the measured
//! force would be on both sides of the regression.
//!
//! The first model is the baseline. An effect that delays, distorts or follows the force biases the mass and friction of
//! that baseline, and its own size has an error of second order. Once the other effects are known, the model has them all.

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
