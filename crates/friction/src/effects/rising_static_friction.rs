//! The longer a contact rests, the harder it breaks away.
//!
//! Contact age A follows the ageing law of rate-and-state friction (Dieterich, Ruina): dA/dt = 1 − A·|v|/x_r. At rest A is
//! the dwell time; sliding renews the contact over the distance x_r, so no threshold for "at rest" is needed.
//! F = s·force·(1 − exp(−A/rest_time)); by direction. s = sgn v, at rest the direction of the applied force: that is
//! what a break-away has to overcome, and a law beside it balances the rest.
//!
//! * Signature: a peak at break-away, of the size of the dwell before it.
//! * Confused with: presliding (.96); in steady creep it also weakens with speed, like stribeck at x_r/rest_time.
//! * Told apart by: dwells of different length.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature, by_direction};
use crate::{Motion, Scalar, mean_decay};

/// Break-away friction that grows with rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RisingStaticFriction;

impl Signature for RisingStaticFriction {
    const ID: &'static str = "rising_static_friction";
    const SAYS: &'static str = "The longer the parts rest, the more force it takes to start moving.";
    const EQUATION: &'static str = "s*force*(1 - exp(-A/rest_time)), dA/dt = 1 - A*|v|/x_r";
    const GAINS: &'static [Parameter] = &[
        Parameter::new(
            "force_p",
            "N",
            (0.0, 1e6),
            "break-away friction gained by long rest against positive motion",
        ),
        Parameter::new(
            "force_n",
            "N",
            (0.0, 1e6),
            "break-away friction gained by long rest against negative motion",
        ),
    ];
    const SHAPE: &'static [Parameter] = &[
        Parameter::new("rest_time", "s", (1e-3, 1e5), "rest after which 63 % is gained"),
        Parameter::new("x_r", "m", (1e-8, 1.0), "distance slid that renews the contact"),
    ];

    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [rest_time, x_r] = *shape;
        let [age, ..] = memory;
        let (v, zero) = (motion.velocity, S::zero());
        let slid = motion.displacement.abs() / x_r;
        // an age beyond all numbers would make 0·∞ of a renewed contact
        *age = (*age * (-slid).exp() + motion.dt.max(zero) * mean_decay(slid)).min(S::lit(1e30));
        let direction = if v == zero { motion.applied } else { v };
        by_direction(direction, direction.sgn() * (S::one() - (-(*age / rest_time)).exp()))
    }
}
