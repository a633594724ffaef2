//! Magnets that prefer some positions over others (detent, cogging).
//!
//! F = Σ cosine_k·cos(2πk·x/λ) + sine_k·sin(2πk·x/λ), k = 1, 2, λ = wavelength.
//!
//! * Signature: a line in *position* frequency, the same at all speeds and in both directions.
//! * Confused with: encoder_eccentricity (grows with v²), torque_ripple (grows with F).
//! * Told apart by: three speeds.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature, wave};
use crate::{Motion, Scalar};

/// Cogging torque, two harmonics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cogging;

impl Signature for Cogging {
    const ID: &'static str = "cogging";
    const SAYS: &'static str =
        "The motor has preferred positions: a force that repeats every fixed distance.";
    const EQUATION: &'static str = "cosine_1*cos(2*pi*x/wavelength) + sine_1*sin(2*pi*x/wavelength) + cosine_2*cos(4*pi*x/wavelength) + sine_2*sin(4*pi*x/wavelength)";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("cosine_1", "N", (-1e6, 1e6), "cosine of the first harmonic"),
        Parameter::new("sine_1", "N", (-1e6, 1e6), "sine of the first harmonic"),
        Parameter::new("cosine_2", "N", (-1e6, 1e6), "cosine of the second harmonic"),
        Parameter::new("sine_2", "N", (-1e6, 1e6), "sine of the second harmonic"),
    ];
    const SHAPE: &'static [Parameter] =
        &[Parameter::new("wavelength", "m", (1e-6, 10.0), "distance of one period")];

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
