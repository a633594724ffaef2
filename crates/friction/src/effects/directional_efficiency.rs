//! Losses of a transmission that depend on which way the power flows.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, Describe, EITHER_OR_BOTH, LookedFor, Parameter, Quantity, Seat};
use crate::{Dimension, Motion, Scalar};

/// Friction as a share of the applied force: one share while the force drives, another while it is driven back.
///
/// F = s·driving·|F_a| where F_a·v > 0, s·back_driven·|F_a| where F_a·v < 0, s = sgn v. With equal shares it is the second
/// part of `load_dependent_friction`, which has one parameter less and is named in its place.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let worm = Effect { kind: EffectKind::DirectionalEfficiency, gains: [0.5, 0.2, 0.0, 0.0], shape: [0.0; 2] };
/// let force = |velocity, applied| -> f64 {
///     worm.step(&mut EffectState::default(), &Motion { velocity, applied, ..Motion::default() })
/// };
/// assert_eq!((force(0.1, 4.0), force(-0.1, 4.0)), (2.0, -0.8)); // N: the load is lifted, and let down
/// assert_eq!((force(-0.1, -4.0), force(0.0, 4.0)), (-2.0, 0.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DirectionalEfficiency;

impl Describe for DirectionalEfficiency {
    const ABOUT: About = About {
        id: "directional_efficiency",
        says: "The transmission loses another share of the force when it drives the load than when the load drives it.",
        equation: "s*|F_a|*driving where F_a*v > 0, s*|F_a|*back_driven where F_a*v < 0",
        shows: "grows with the force, and differs with the sign of F_a·v",
        confused_with: "load_dependent_friction (equal shares), force_gain_asymmetry",
        told_apart_by: "lifting and lowering the same load",
        gains: &[
            Parameter::gain("driving", Dimension::NUMBER, (0.0, 1.0), "share of the force lost while it drives"),
            // a gear that hardly turns back holds a load with little force
            Parameter::gain("back_driven", Dimension::NUMBER, (0.0, 10.0), "share of the force lost while the load drives"),
        ],
        groups: EITHER_OR_BOTH,
        reads: &[Quantity::Velocity, Quantity::Force],
        opposes_motion: true,
        seat: Seat::Drive,
        bench_test: Some("lift and lower the same known load"),
        looked_for: LookedFor::Nowhere,
        ..About::EFFECT
    };
}

impl Signature for DirectionalEfficiency {
    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let zero = S::zero();
        let s = motion.velocity.sgn();
        let along = s * motion.applied;
        // the two sides of zero: nothing jumps where the force changes sign
        [s * along.max(zero), s * (-along).max(zero), zero, zero]
    }
}
