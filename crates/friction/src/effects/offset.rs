//! A constant force: weight along a linear axis, the zero of a load cell or of an amplifier.
//!
//! F = force.
//!
//! * Signature: constant.
//! * Confused with: Coulomb friction that differs by direction, while moving (2 % is left).
//! * Told apart by: rest.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature};
use crate::{Motion, Scalar};

/// A constant force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Offset;

impl Signature for Offset {
    const ID: &'static str = "offset";
    const SAYS: &'static str = "A constant force is there that the model does not have.";
    const EQUATION: &'static str = "force";
    const GAINS: &'static [Parameter] = &[Parameter::new("force", "N", (-1e6, 1e6), "the constant force")];
    const SHAPE: &'static [Parameter] = &[];

    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        _motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let zero = S::zero();
        [S::one(), zero, zero, zero]
    }
}
