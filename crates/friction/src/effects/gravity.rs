//! The weight of an arm or a pendulum.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, Describe, Parameter, BOTH, Quantity, Seat};
use crate::{Dimension, Geometry, Motion, Scalar};

/// Weight of an arm; for an axis.
///
/// F = sine·sin q + cosine·cos q = m·g·l·sin(q + φ), with q in rad. On a slide weight is a constant: see
/// [`Offset`](super::Offset).
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let arm = Effect { kind: EffectKind::Gravity, gains: [2.0, 0.0, 0.0, 0.0], shape: [0.0; 2] };
/// let level = Motion { position: std::f64::consts::FRAC_PI_2, ..Motion::default() };
/// let torque: f64 = arm.step(&mut EffectState::default(), &level);
/// assert!((torque - 2.0).abs() < 1e-12); // N·m
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gravity;

impl Describe for Gravity {
    const ABOUT: About = About {
        id: "gravity",
        says: "The weight of the moving part pulls differently at different angles.",
        equation: "sine*sin(q) + cosine*cos(q)",
        shows: "even in v, against q",
        confused_with: "offset, and spring where the stroke is small",
        told_apart_by: "turning the machine over",
        gains: &[
            Parameter::gain("sine", Dimension::FORCE, (-1e6, 1e6), "torque of the weight at q = 90°"),
            Parameter::gain("cosine", Dimension::FORCE, (-1e6, 1e6), "torque of the weight at q = 0"),
        ],
        groups: BOTH,
        at_an_angle: true,
        reads: &[Quantity::Position],
        seat: Seat::Body,
        only: Some((Geometry::Rotary, "weight is a constant along a slide: it is the offset")),
        bench_test: Some("turn the axis over and repeat the move: weight changes its sign"),
        ..About::EFFECT
    };
}

impl Signature for Gravity {
    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let (q, zero) = (motion.position, S::zero());
        [q.sin(), q.cos(), zero, zero]
    }
}
