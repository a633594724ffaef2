//! A motor that gives a little more or less force for the same current, by position.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature, wave};
use super::{About, Acts, BOTH, Describe, Parameter, Quantity, Scale, Seat};
use crate::{Dimension, Motion, Scalar};

/// Ripple of the motor's force.
///
/// F = F_a·(cosine·cos(2πx/λ) + sine·sin(2πx/λ)), F_a the applied force, λ = wavelength.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let ripple = Effect { kind: EffectKind::TorqueRipple, gains: [0.05, 0.0, 0.0, 0.0], shape: [0.004, 0.0] };
/// let driven = Motion { applied: 3.0, ..Motion::default() };
/// let force: f64 = ripple.step(&mut EffectState::default(), &driven);
/// assert!((force - 0.15).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TorqueRipple;

impl Describe for TorqueRipple {
    const ABOUT: About = About {
        id: "torque_ripple",
        says: "The motor's force rises and falls with position, in proportion to the force itself.",
        equation: "F_a*(cosine*cos(2*pi*x/wavelength) + sine*sin(2*pi*x/wavelength))",
        shows: "a line in position frequency, in proportion to the force",
        confused_with: "periodic_friction (.97)",
        told_apart_by: "a scan over load",
        gains: &[
            Parameter::gain("cosine", Dimension::NUMBER, (-1.0, 1.0), "cosine of the ripple, share of the force"),
            Parameter::gain("sine", Dimension::NUMBER, (-1.0, 1.0), "sine of the ripple, share of the force"),
        ],
        groups: BOTH,
        shape: &[Parameter::shape("wavelength", Scale::Wavelength, (1e-6, 10.0), "distance of one period")],
        several_by: Some(0),
        reads: &[Quantity::Position, Quantity::Force],
        seat: Seat::Drive,
        acts: Acts::OnForce,
        ..About::EFFECT
    };
}

impl Signature for TorqueRipple {
    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [wavelength, _] = *shape;
        let (force, zero) = (motion.applied, S::zero());
        let (s, c) = wave(motion.position, wavelength);
        [force * c, force * s, zero, zero]
    }
}
