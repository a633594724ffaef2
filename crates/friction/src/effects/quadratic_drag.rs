//! Drag of a fluid or of windage.
//!
//! F = c·v·|v|; by direction.
//!
//! * Signature: odd in v, smooth, strongest at the highest speed.
//! * Confused with: sublinear_viscous (.80-.93), viscous friction itself (3-29 % is left once that is projected out),
//!   load_dependent_friction (.91).
//! * Told apart by: a wider range of speeds.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature, by_direction};
use crate::{Motion, Scalar};

/// Drag with the square of the speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuadraticDrag;

impl Signature for QuadraticDrag {
    const ID: &'static str = "quadratic_drag";
    const SAYS: &'static str = "Friction grows with the square of the speed, like air or fluid drag.";
    const EQUATION: &'static str = "c*v*|v|";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("c_p", "N·s²/m²", (0.0, 1e6), "drag coefficient in positive motion"),
        Parameter::new("c_n", "N·s²/m²", (0.0, 1e6), "drag coefficient in negative motion"),
    ];
    const SHAPE: &'static [Parameter] = &[];

    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let v = motion.velocity;
        by_direction(v, v * v.abs())
    }
}
