//! A motor that gives a little more or less force for the same current, by position.
//!
//! F = F_a·(cosine·cos(2πx/λ) + sine·sin(2πx/λ)), F_a the applied force, λ = wavelength.
//!
//! * Signature: a line in position frequency, in proportion to the force.
//! * Confused with: periodic_friction (.97).
//! * Told apart by: a scan over load.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature, wave};
use crate::{Motion, Scalar};

/// Ripple of the motor's force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TorqueRipple;

impl Signature for TorqueRipple {
    const ID: &'static str = "torque_ripple";
    const SAYS: &'static str =
        "The motor's force rises and falls with position, in proportion to the force itself.";
    const EQUATION: &'static str = "F_a*(cosine*cos(2*pi*x/wavelength) + sine*sin(2*pi*x/wavelength))";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("cosine", "1", (-1.0, 1.0), "cosine of the ripple, share of the force"),
        Parameter::new("sine", "1", (-1.0, 1.0), "sine of the ripple, share of the force"),
    ];
    const SHAPE: &'static [Parameter] =
        &[Parameter::new("wavelength", "m", (1e-6, 10.0), "distance of one period")];

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
