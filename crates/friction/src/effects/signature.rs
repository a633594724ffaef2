//! What every effect of the catalogue is.

use crate::{Invalid, Motion, Scalar};

/// Most gains an effect has.
pub const MAX_GAINS: usize = 4;
/// Most shape parameters an effect has.
pub const MAX_SHAPE: usize = 2;
/// Most words an effect remembers.
pub const MAX_MEMORY: usize = 4;

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name as a user types it and as it stands in files.
    pub name: &'static str,
    /// Unit on a linear axis.
    pub unit: &'static str,
    /// Smallest physical value.
    pub min: f64,
    /// Largest accepted value.
    pub max: f64,
    /// What it is, for a person.
    pub what: &'static str,
}

impl Parameter {
    pub(super) const fn new(
        name: &'static str,
        unit: &'static str,
        range: (f64, f64),
        what: &'static str,
    ) -> Self {
        Self { name, unit, min: range.0, max: range.1, what }
    }
}

/// An effect: a force that is linear in its gains once its shape is given.
pub trait Signature {
    /// Fixed id, as in files and reports.
    const ID: &'static str;
    /// One plain sentence for a person.
    const SAYS: &'static str;
    /// The equation as text, in the names of `GAINS` and `SHAPE`.
    const EQUATION: &'static str;
    /// Parameters the force is linear in, at most [`MAX_GAINS`].
    const GAINS: &'static [Parameter];
    /// Parameters the force is not linear in, at most [`MAX_SHAPE`].
    const SHAPE: &'static [Parameter];

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
