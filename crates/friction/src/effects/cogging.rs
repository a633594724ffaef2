//! Magnets that prefer some positions over others.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature, wave};
use super::{About, Describe, Parameter, Example, Quantity, Scale, Seat};
use crate::{Dimension, Motion, Scalar};

/// Cogging torque (detent), two harmonics.
///
/// F = Σ cosine_k·cos(2πk·x/λ) + sine_k·sin(2πk·x/λ), k = 1, 2, λ = wavelength.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let detent = Effect { kind: EffectKind::Cogging, gains: [0.2, 0.15, 0.0, 0.0], shape: [0.004, 0.0] };
/// let quarter = Motion { position: 0.001, ..Motion::default() };
/// let force: f64 = detent.step(&mut EffectState::default(), &quarter);
/// assert!((force - 0.15).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cogging;

impl Describe for Cogging {
    const ABOUT: About = About {
        id: "cogging",
        says: "The motor has preferred positions: a force that repeats every fixed distance.",
        equation: "cosine_1*cos(2*pi*x/wavelength) + sine_1*sin(2*pi*x/wavelength) + cosine_2*cos(4*pi*x/wavelength) + sine_2*sin(4*pi*x/wavelength)",
        shows: "a line in position frequency, the same at all speeds and in both directions",
        confused_with: "encoder_eccentricity (grows with v²), torque_ripple (grows with F)",
        told_apart_by: "three speeds",
        gains: &[
            Parameter::gain("cosine_1", Dimension::FORCE, (-1e6, 1e6), "cosine of the first harmonic"),
            Parameter::gain("sine_1", Dimension::FORCE, (-1e6, 1e6), "sine of the first harmonic"),
            Parameter::gain("cosine_2", Dimension::FORCE, (-1e6, 1e6), "cosine of the second harmonic"),
            Parameter::gain("sine_2", Dimension::FORCE, (-1e6, 1e6), "sine of the second harmonic"),
        ],
        groups: &[&[&[0], &[1]], &[&[0], &[1], &[2], &[3]]],
        shape: &[Parameter::shape("wavelength", Scale::Wavelength, (1e-6, 10.0), "distance of one period")],
        several_by: Some(0),
        reads: &[Quantity::Position],
        seat: Seat::Drive,
        example: Some(Example { gains: [0.2, 0.15, 0.0, 0.0], shape: [0.004, 0.0] }),
        ..About::EFFECT
    };
}

impl Signature for Cogging {
    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [wavelength, _] = *shape;
        let (s, c) = wave(motion.position, wavelength);
        let two = S::lit(2.0);
        [c, s, c * c - s * s, two * s * c]
    }
}
