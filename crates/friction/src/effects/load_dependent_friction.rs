//! Friction that grows with the load on the contact.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, Describe, Parameter, EITHER, Quantity};
use crate::{Dimension, Motion, Scalar};

/// Friction that grows with load.
///
/// F = s·(mu·N + share·|F_a|), s = sgn v. N is the measured normal load, in N on an axis as well; where it is not known that part
/// is 0. F_a is the applied force: in a gear or a screw the driving force itself loads the contact.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let screw = Effect { kind: EffectKind::LoadDependentFriction, gains: [0.2, 0.1, 0.0, 0.0], shape: [0.0; 2] };
/// let pushed = Motion { velocity: 0.1, normal: Some(4.0), applied: -3.0, ..Motion::default() };
/// let force: f64 = screw.step(&mut EffectState::default(), &pushed);
/// assert!((force - 1.1).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoadDependentFriction;

impl Describe for LoadDependentFriction {
    const ABOUT: About = About {
        id: "load_dependent_friction",
        says: "Friction grows with the load on the contact.",
        equation: "s*(mu*N + share*|F_a|)",
        shows: "grows with load; with |F_a|, strongest at the acceleration peaks",
        confused_with: "quadratic_drag (.91), a cubic in F (.97)",
        told_apart_by: "added mass; a measured normal force",
        gains: &[
            Parameter::gain("mu", Dimension::FORCE.per(Dimension::LOAD), (0.0, 10.0), "coefficient of friction on the normal load; on an axis times the radius of the contact"),
            Parameter::gain("share", Dimension::NUMBER, (0.0, 1.0), "friction as a share of the applied force"),
        ],
        groups: EITHER,
        reads: &[Quantity::Velocity, Quantity::Load, Quantity::Force],
        opposes_motion: true,
        ..About::EFFECT
    };
}

impl Signature for LoadDependentFriction {
    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let (s, zero) = (motion.velocity.sgn(), S::zero());
        [s * motion.normal.unwrap_or(zero), s * motion.applied.abs(), zero, zero]
    }
}
