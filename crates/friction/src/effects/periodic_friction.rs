//! Friction with a pattern along the stroke: balls and rollers passing, a lead screw's turn, a textured surface.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature, wave};
use super::{About, Describe, Parameter, BOTH, Example, Quantity, Scale};
use crate::{Dimension, Motion, Scalar};

/// Friction that repeats over a distance.
///
/// F = s·(cosine·cos(2πx/λ) + sine·sin(2πx/λ)), s = sgn v, λ = wavelength.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let balls = Effect { kind: EffectKind::PeriodicFriction, gains: [0.2, 0.15, 0.0, 0.0], shape: [0.004, 0.0] };
/// let back = Motion { position: 0.001, velocity: -0.1, ..Motion::default() };
/// let force: f64 = balls.step(&mut EffectState::default(), &back);
/// assert!((force + 0.15).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PeriodicFriction;

impl Describe for PeriodicFriction {
    const ABOUT: About = About {
        id: "periodic_friction",
        says: "Friction rises and falls in a pattern that repeats every fixed distance.",
        equation: "s*(cosine*cos(2*pi*x/wavelength) + sine*sin(2*pi*x/wavelength))",
        shows: "a line in position frequency that flips with direction",
        confused_with: "torque_ripple (.97)",
        told_apart_by: "the same motion with and without load",
        gains: &[
            Parameter::gain("cosine", Dimension::FORCE, (-1e6, 1e6), "cosine of the pattern"),
            Parameter::gain("sine", Dimension::FORCE, (-1e6, 1e6), "sine of the pattern"),
        ],
        groups: BOTH,
        shape: &[Parameter::shape("wavelength", Scale::Wavelength, (1e-6, 10.0), "distance of one period")],
        several_by: Some(0),
        reads: &[Quantity::Position, Quantity::Velocity],
        opposes_motion: true,
        example: Some(Example { gains: [0.2, 0.15, 0.0, 0.0], shape: [0.004, 0.0] }),
        ..About::EFFECT
    };
}

impl Signature for PeriodicFriction {
    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [wavelength, _] = *shape;
        let (direction, zero) = (motion.velocity.sgn(), S::zero());
        let (s, c) = wave(motion.position, wavelength);
        [direction * c, direction * s, zero, zero]
    }
}
