//! Friction that is not the same everywhere along the stroke: preload, a worn or dry spot, a bent rail.
//!
//! F = s·(slope·x + curve·x²), s = sgn v; by direction. The level at x = 0 is the law's.
//!
//! * Signature: odd in v, and against x.
//! * Confused with: force_gain_asymmetry (1.0 on one sine).
//! * Told apart by: micro-reversals around several positions.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature};
use crate::{Motion, Scalar};

/// Friction that depends on position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PositionDependentFriction;

impl Signature for PositionDependentFriction {
    const ID: &'static str = "position_dependent_friction";
    const SAYS: &'static str = "Friction is not the same everywhere along the stroke.";
    const EQUATION: &'static str = "s*(slope*x + curve*x^2)";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("slope_p", "N/m", (-1e6, 1e6), "change of friction with position, positive motion"),
        Parameter::new("slope_n", "N/m", (-1e6, 1e6), "change of friction with position, negative motion"),
        Parameter::new(
            "curve_p",
            "N/m²",
            (-1e9, 1e9),
            "curvature of friction over position, positive motion",
        ),
        Parameter::new(
            "curve_n",
            "N/m²",
            (-1e9, 1e9),
            "curvature of friction over position, negative motion",
        ),
    ];
    const SHAPE: &'static [Parameter] = &[];

    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let (x, v, zero) = (motion.position, motion.velocity, S::zero());
        let (slope, curve) = (v.sgn() * x, v.sgn() * x * x);
        if v > zero {
            [slope, zero, curve, zero]
        } else if v < zero {
            [zero, slope, zero, curve]
        } else {
            [zero; MAX_GAINS]
        }
    }
}
