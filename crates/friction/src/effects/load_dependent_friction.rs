//! Friction that grows with the load on the contact.
//!
//! F = s·(mu·N + share·|F_a|), s = sgn v. N is the measured normal load; where it is not known that part is 0. F_a is the
//! applied force: in a gear or a screw the driving force itself loads the contact.
//!
//! * Signature: grows with load; with |F_a|, strongest at the acceleration peaks.
//! * Confused with: quadratic_drag (.91), a cubic in F (.97).
//! * Told apart by: added mass, a measured normal force.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature};
use crate::{Motion, Scalar};

/// Friction that grows with load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoadDependentFriction;

impl Signature for LoadDependentFriction {
    const ID: &'static str = "load_dependent_friction";
    const SAYS: &'static str = "Friction grows with the load on the contact.";
    const EQUATION: &'static str = "s*(mu*N + share*|F_a|)";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("mu", "1", (0.0, 10.0), "coefficient of friction on the normal load"),
        Parameter::new("share", "1", (0.0, 1.0), "friction as a share of the applied force"),
    ];
    const SHAPE: &'static [Parameter] = &[];

    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let (s, zero) = (motion.velocity.sgn(), S::zero());
        [s * motion.normal.unwrap_or(zero), s * motion.applied.abs(), zero, zero]
    }
}
