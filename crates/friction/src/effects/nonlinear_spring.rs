//! A spring that stiffens with deflection.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, Describe, Parameter, EITHER_OR_BOTH, Example, Quantity, Seat};
use crate::{Dimension, Motion, Scalar};

/// A spring that stiffens.
///
/// F = cubic·x³ + quadratic·x².
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let flexure = Effect { kind: EffectKind::NonlinearSpring, gains: [6e5, 0.0, 0.0, 0.0], shape: [0.0; 2] };
/// let force: f64 = flexure.step(&mut EffectState::default(), &Motion { position: -0.01, ..Motion::default() });
/// assert!((force + 0.6).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NonlinearSpring;

impl Describe for NonlinearSpring {
    const ABOUT: About = About {
        id: "nonlinear_spring",
        says: "Something pulls back with position, and stiffens toward the ends.",
        equation: "cubic*x^3 + quadratic*x^2",
        shows: "even in v, against x, growing toward the ends",
        confused_with: "spring, hard_stop (.68-.85)",
        told_apart_by: "a ladder of amplitudes",
        gains: &[
            Parameter::gain("cubic", Dimension::FORCE.per(Dimension::LENGTH.power(3)), (-1e12, 1e12), "cubic stiffness"),
            Parameter::gain("quadratic", Dimension::FORCE.per(Dimension::LENGTH.power(2)), (-1e12, 1e12), "quadratic stiffness"),
        ],
        groups: EITHER_OR_BOTH,
        reads: &[Quantity::Position],
        seat: Seat::Body,
        example: Some(Example { gains: [6e5, 0.0, 0.0, 0.0], shape: [0.0; 2] }),
        ..About::EFFECT
    };
}

impl Signature for NonlinearSpring {
    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let (x, zero) = (motion.position, S::zero());
        [x * x * x, x * x, zero, zero]
    }
}
