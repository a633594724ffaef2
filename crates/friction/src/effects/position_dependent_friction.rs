//! Friction that is not the same everywhere along the stroke: preload, a worn or dry spot, a bent rail.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, Describe, Parameter, Example, Quantity};
use crate::{Dimension, Motion, Scalar};

/// Friction that depends on position.
///
/// F = s·(slope·x + curve·x²), s = sgn v; by direction. The level at x = 0 is the law's.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let preload =
///     Effect { kind: EffectKind::PositionDependentFriction, gains: [35.0, 20.0, 0.0, 0.0], shape: [0.0; 2] };
/// let back = Motion { position: 0.01, velocity: -0.1, ..Motion::default() };
/// let force: f64 = preload.step(&mut EffectState::default(), &back);
/// assert!((force + 0.2).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PositionDependentFriction;

/// N/m².
const CURVE: Dimension = Dimension::FORCE.per(Dimension::LENGTH.power(2));

impl Describe for PositionDependentFriction {
    const ABOUT: About = About {
        id: "position_dependent_friction",
        says: "Friction is not the same everywhere along the stroke.",
        equation: "s*(slope*x + curve*x^2)",
        shows: "odd in v, and against x",
        confused_with: "force_gain_asymmetry (1.0 on one sine)",
        told_apart_by: "micro-reversals around several positions",
        gains: &[
            Parameter::gain("slope_p", Dimension::STIFFNESS, (-1e6, 1e6), "change of friction with position, positive motion"),
            Parameter::gain("slope_n", Dimension::STIFFNESS, (-1e6, 1e6), "change of friction with position, negative motion"),
            Parameter::gain("curve_p", CURVE, (-1e9, 1e9), "curvature of friction over position, positive motion"),
            Parameter::gain("curve_n", CURVE, (-1e9, 1e9), "curvature of friction over position, negative motion"),
        ],
        groups: &[&[&[0, 1]], &[&[0], &[1]], &[&[0, 1], &[2, 3]], &[&[0], &[1], &[2], &[3]]],
        reads: &[Quantity::Position, Quantity::Velocity],
        opposes_motion: true,
        example: Some(Example { gains: [35.0, 35.0, 0.0, 0.0], shape: [0.0; 2] }),
        ..About::EFFECT
    };
}

impl Signature for PositionDependentFriction {
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
