//! A spring to the frame: a cable, a flexure, a hose.
//!
//! F = stiffness·x. A rest position other than x = 0 is a constant force: see offset.
//!
//! * Signature: even in v, against x.
//! * Confused with: **mass, on one sine** (x and a are the same curve there; nothing is left of it).
//! * Told apart by: a second frequency; static holds.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature};
use crate::{Motion, Scalar};

/// A linear spring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Spring;

impl Signature for Spring {
    const ID: &'static str = "spring";
    const SAYS: &'static str = "Something pulls back in proportion to position, like a spring.";
    const EQUATION: &'static str = "stiffness*x";
    const GAINS: &'static [Parameter] = &[Parameter::new("stiffness", "N/m", (0.0, 1e9), "stiffness")];
    const SHAPE: &'static [Parameter] = &[];

    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let zero = S::zero();
        [motion.position, zero, zero, zero]
    }
}
