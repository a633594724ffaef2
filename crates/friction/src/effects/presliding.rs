//! Friction that builds up over a distance after a reversal: bristles bend before they slip.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature, bristle, by_direction};
use super::{About, Describe, Parameter, BY_DIRECTION, Example, Quantity, Scale};
use crate::{Dimension, Motion, Scalar};

/// The elastic turn-round of friction after a reversal.
///
/// F = force·(z − s), dz/dx = (1 − s·z)/x_s, s = sgn v: what Dahl's friction has beyond Coulomb's; by direction. At rest the
/// bristles hold with the gain they were bent with.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let bristles = Effect { kind: EffectKind::Presliding, gains: [0.5, 0.5, 0.0, 0.0], shape: [4e-4, 0.0] };
/// let mut state = EffectState::default();
/// let slide = Motion { velocity: 0.01, displacement: 4e-4, ..Motion::default() };
/// let force: f64 = bristles.step(&mut state, &slide); // after x_s from a fresh contact, e⁻¹ is still missing
/// assert!((force + 0.5 / std::f64::consts::E).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Presliding;

impl Describe for Presliding {
    const ABOUT: About = About {
        id: "presliding",
        says: "After each reversal friction builds up over a short distance instead of at once, like a spring between the surfaces.",
        equation: "force*(z - s), dz/dx = (1 - s*z)/x_s",
        shows: "a lobe that decays with the distance after a reversal, at any speed",
        confused_with: "its own variants (.99: one class), frictional_lag (.89), rising_static_friction (.96)",
        told_apart_by: "micro-reversals; moves with dwells (.13)",
        gains: &[
            Parameter::gain("force_p", Dimension::FORCE, (0.0, 1e6), "friction that turns round elastically in positive motion"),
            Parameter::gain("force_n", Dimension::FORCE, (0.0, 1e6), "friction that turns round elastically in negative motion"),
        ],
        groups: BY_DIRECTION,
        shape: &[Parameter::shape("x_s", Scale::Distance, (1e-8, 1.0), "distance over which friction turns round")],
        several_by: Some(0),
        reads: &[Quantity::Displacement, Quantity::Velocity],
        example: Some(Example { gains: [0.5, 0.5, 0.0, 0.0], shape: [4e-4, 0.0] }),
        ..About::EFFECT
    };
}

impl Signature for Presliding {
    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [x_s, _] = *shape;
        let [z, direction, ..] = memory;
        let s = motion.velocity.sgn();
        *z = bristle(*z, motion.displacement, x_s);
        if s != S::zero() {
            *direction = s; // at rest the bristles hold with the gain they were bent with
        }
        by_direction(*direction, *z - s)
    }
}
