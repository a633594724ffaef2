//! Friction with a pattern along the stroke: balls and rollers passing, a lead screw's turn, a textured surface.
//!
//! F = s·(cosine·cos(2πx/λ) + sine·sin(2πx/λ)), s = sgn v, λ = wavelength.
//!
//! * Signature: a line in position frequency that flips with direction.
//! * Confused with: torque_ripple (.97).
//! * Told apart by: the same motion with and without load.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature, wave};
use crate::{Motion, Scalar};

/// Friction that repeats over a distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PeriodicFriction;

impl Signature for PeriodicFriction {
    const ID: &'static str = "periodic_friction";
    const SAYS: &'static str = "Friction rises and falls in a pattern that repeats every fixed distance.";
    const EQUATION: &'static str = "s*(cosine*cos(2*pi*x/wavelength) + sine*sin(2*pi*x/wavelength))";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("cosine", "N", (-1e6, 1e6), "cosine of the pattern"),
        Parameter::new("sine", "N", (-1e6, 1e6), "sine of the pattern"),
    ];
    const SHAPE: &'static [Parameter] =
        &[Parameter::new("wavelength", "m", (1e-6, 10.0), "distance of one period")];

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
