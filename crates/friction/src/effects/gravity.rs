//! The weight of an arm or a pendulum; for a rotary axis.
//!
//! F = sine·sin q + cosine·cos q = m·g·l·sin(q + φ), with q in rad. On a linear axis weight is a constant: see offset.
//!
//! * Signature: even in v, against q.
//! * Confused with: offset, and spring where the stroke is small.
//! * Told apart by: turning the machine over.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature};
use crate::{Motion, Scalar};

/// Weight of an arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gravity;

impl Signature for Gravity {
    const ID: &'static str = "gravity";
    const SAYS: &'static str = "The weight of the moving part pulls differently at different angles.";
    const EQUATION: &'static str = "sine*sin(q) + cosine*cos(q)";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("sine", "N·m", (-1e6, 1e6), "torque of the weight at q = 90°"),
        Parameter::new("cosine", "N·m", (-1e6, 1e6), "torque of the weight at q = 0"),
    ];
    const SHAPE: &'static [Parameter] = &[];

    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let (q, zero) = (motion.position, S::zero());
        [q.sin(), q.cos(), zero, zero]
    }
}
