//! A spring to the frame: a cable, a flexure, a hose.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, Describe, Parameter, Example, Quantity, Seat};
use crate::{Dimension, Motion, Scalar};

/// A linear spring.
///
/// F = stiffness·x. A rest position other than x = 0 is a constant force: see [`Offset`](super::Offset).
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let cable = Effect { kind: EffectKind::Spring, gains: [40.0, 0.0, 0.0, 0.0], shape: [0.0; 2] };
/// let force: f64 = cable.step(&mut EffectState::default(), &Motion { position: 0.01, ..Motion::default() });
/// assert!((force - 0.4).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Spring;

impl Describe for Spring {
    const ABOUT: About = About {
        id: "spring",
        says: "Something pulls back in proportion to position, like a spring.",
        equation: "stiffness*x",
        shows: "even in v, against x",
        confused_with: "mass, on one sine: x and a are the same curve there, and nothing is left of it",
        told_apart_by: "a second frequency; static holds",
        gains: &[Parameter::gain("stiffness", Dimension::STIFFNESS, (0.0, 1e9), "stiffness")],
        reads: &[Quantity::Position],
        seat: Seat::Body,
        example: Some(Example { gains: [40.0, 0.0, 0.0, 0.0], shape: [0.0; 2] }),
        ..About::EFFECT
    };
}

impl Signature for Spring {
    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let zero = S::zero();
        [motion.position, zero, zero, zero]
    }
}
