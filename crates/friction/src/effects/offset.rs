//! A constant force: weight along a slide, the zero of a load cell or of an amplifier.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, Describe, Parameter, Seat};
use crate::{Dimension, Motion, Scalar};

/// A constant force.
///
/// F = force.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let zero = Effect { kind: EffectKind::Offset, gains: [-0.1, 0.0, 0.0, 0.0], shape: [0.0; 2] };
/// let force: f64 = zero.step(&mut EffectState::default(), &Motion::default());
/// assert!((force + 0.1).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Offset;

impl Describe for Offset {
    const ABOUT: About = About {
        id: "offset",
        says: "A constant force is there that the model does not have.",
        equation: "force",
        shows: "constant",
        confused_with: "Coulomb friction that differs by direction, while moving (2 % is left)",
        told_apart_by: "rest",
        gains: &[Parameter::gain("force", Dimension::FORCE, (-1e6, 1e6), "the constant force")],
        seat: Seat::Unknown,
        bench_test: Some("read the force at rest with nothing touching the load cell: what it shows then is the offset"),
        shown_by_motion: false,
        ..About::EFFECT
    };
}

impl Signature for Offset {
    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        _motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let zero = S::zero();
        [S::one(), zero, zero, zero]
    }
}
