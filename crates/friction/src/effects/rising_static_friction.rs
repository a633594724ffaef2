//! A contact that breaks away harder the longer it rests.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature, by_direction};
use super::{About, Describe, Parameter, BY_DIRECTION, Quantity, Scale};
use crate::{Dimension, Motion, Scalar, mean_decay};

/// Break-away friction that grows with rest.
///
/// The contact age A follows the ageing law of rate-and-state friction (Dieterich, Ruina): dA/dt = 1 − A·|v|/x_r. At rest A is
/// the dwell time; sliding renews the contact over the distance x_r, so no threshold for "at rest" is needed.
/// F = s·force·(1 − exp(−A/rest_time)); by direction. s = sgn v, at rest the direction of the applied force: that is
/// what a break-away has to overcome, and a law beside it balances the rest.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let ageing = Effect { kind: EffectKind::RisingStaticFriction, gains: [1.0, 1.0, 0.0, 0.0], shape: [2.0, 1e-4] };
/// let rest = Motion { dt: 2.0, applied: 0.3, ..Motion::default() };
/// let force: f64 = ageing.step(&mut EffectState::default(), &rest);
/// assert!((force - (1.0 - 1.0 / std::f64::consts::E)).abs() < 1e-12); // N: 63 % after the rest time
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RisingStaticFriction;

impl Describe for RisingStaticFriction {
    const ABOUT: About = About {
        id: "rising_static_friction",
        says: "The longer the parts rest, the more force it takes to start moving.",
        equation: "s*force*(1 - exp(-A/rest_time)), dA/dt = 1 - A*|v|/x_r",
        shows: "a peak at break-away, as high as the dwell before it was long",
        confused_with: "presliding (.96); in steady creep it also weakens with speed, like stribeck at x_r/rest_time",
        told_apart_by: "dwells of different length",
        gains: &[
            Parameter::gain("force_p", Dimension::FORCE, (0.0, 1e6), "break-away friction gained by long rest against positive motion"),
            Parameter::gain("force_n", Dimension::FORCE, (0.0, 1e6), "break-away friction gained by long rest against negative motion"),
        ],
        groups: BY_DIRECTION,
        shape: &[
            Parameter::shape("rest_time", Scale::Rest, (1e-3, 1e5), "rest after which 63 % is gained"),
            Parameter::shape("x_r", Scale::Distance, (1e-8, 1.0), "distance slid that renews the contact"),
        ],
        reads: &[Quantity::Velocity, Quantity::Displacement, Quantity::Time, Quantity::Force],
        opposes_motion: true,
        ..About::EFFECT
    };
}

impl Signature for RisingStaticFriction {
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
