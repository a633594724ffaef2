//! A force as an effect of the catalogue.

pub use super::about::{MAX_GAINS, MAX_SHAPE};
use super::{Describe, EffectKind};
use crate::{Invalid, Motion, Scalar};

/// Most words an effect remembers.
pub const MAX_MEMORY: usize = 4;

/// An effect that adds a force: linear in its gains once its shape is given.
pub trait Signature: Describe {
    /// Force per unit of each gain, N per gain unit, positive against positive motion. Advances `memory`, zero at
    /// the start, by the step. `motion` is finite; what it does not hold (a normal load) contributes 0.
    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS];

    /// What the ranges of single parameters cannot say about the shape.
    ///
    /// # Errors
    /// The parameter that does not fit the others.
    fn check_shape<S: Scalar>(_shape: &[S; MAX_SHAPE]) -> Result<(), Invalid> {
        Ok(())
    }

    /// The effect that this shape is rather a case of.
    #[must_use]
    fn rather(_shape: &[f64; MAX_SHAPE]) -> Option<EffectKind> {
        None
    }
}

/// `value` in the first place when `velocity` is positive, in the second when it is negative: a pair of gains by
/// direction.
pub(super) fn by_direction<S: Scalar>(velocity: S, value: S) -> [S; MAX_GAINS] {
    let zero = S::zero();
    if velocity > zero {
        [value, zero, zero, zero]
    } else if velocity < zero {
        [zero, value, zero, zero]
    } else {
        [zero; MAX_GAINS]
    }
}

/// Sine and cosine of 2πx/λ.
pub(super) fn wave<S: Scalar>(position: S, wavelength: S) -> (S, S) {
    let turns = (position / wavelength).clamp(S::lit(-1e12), S::lit(1e12)); // the sine of infinity is NaN
    let phase = S::lit(core::f64::consts::TAU) * turns;
    (phase.sin(), phase.cos())
}

/// The unit Dahl model dz/dx = (1 − s z)/x_s after sliding `displacement`, |z| ≤ 1.
pub(super) fn bristle<S: Scalar>(z: S, displacement: S, x_s: S) -> S {
    let end = displacement.sgn();
    if end == S::zero() { z } else { end + (z - end) * (-(displacement.abs() / x_s)).exp() }
}
