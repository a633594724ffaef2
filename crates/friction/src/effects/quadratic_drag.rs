//! Drag of a fluid or of windage.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature, by_direction};
use super::{About, Describe, Parameter, BY_DIRECTION, Example, Quantity};
use crate::{Dimension, Motion, Scalar};

/// Drag with the square of the speed.
///
/// F = c·v·|v|; by direction.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let drag = Effect { kind: EffectKind::QuadraticDrag, gains: [30.0, 20.0, 0.0, 0.0], shape: [0.0; 2] };
/// let back = Motion { velocity: -0.1, ..Motion::default() };
/// let force: f64 = drag.step(&mut EffectState::default(), &back);
/// assert!((force + 0.2).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuadraticDrag;

/// N·s²/m².
const DRAG: Dimension = Dimension::FORCE.per(Dimension::VELOCITY.power(2));

impl Describe for QuadraticDrag {
    const ABOUT: About = About {
        id: "quadratic_drag",
        says: "Friction grows with the square of the speed, like air or fluid drag.",
        equation: "c*v*|v|",
        shows: "odd in v, smooth, strongest at the highest speed",
        confused_with: "sublinear_viscous (.80-.93), viscous friction itself (3-29 % is left once that is projected out), load_dependent_friction (.91)",
        told_apart_by: "a wider range of speeds",
        gains: &[
            Parameter::gain("c_p", DRAG, (0.0, 1e6), "drag coefficient in positive motion"),
            Parameter::gain("c_n", DRAG, (0.0, 1e6), "drag coefficient in negative motion"),
        ],
        groups: BY_DIRECTION,
        reads: &[Quantity::Velocity],
        opposes_motion: true,
        example: Some(Example { gains: [30.0, 30.0, 0.0, 0.0], shape: [0.0; 2] }),
        ..About::EFFECT
    };
}

impl Signature for QuadraticDrag {
    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let v = motion.velocity;
        by_direction(v, v * v.abs())
    }
}
