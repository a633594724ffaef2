//! Viscous friction that levels off with speed: the lubricant shears thin, or the film builds up.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature, by_direction};
use super::{About, Describe, Parameter, BY_DIRECTION, Example, Quantity, Scale};
use crate::{Dimension, Motion, Scalar};

/// Largest power of the speed: 1, the steepest a film is, and a margin for the error of an estimate. Steeper friction is
/// another effect, so a fit pushed to this bound is withdrawn.
const STEEPEST: f64 = 1.1;

/// Viscous friction that levels off.
///
/// F = s·force·(1 − exp(−(|v|/v_0)^power)), s = sgn v; by direction. For |v| ≪ v_0 this is the power law
/// s·(|v|/v_0)^power, for |v| ≫ v_0 a level.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let film = Effect { kind: EffectKind::SublinearViscous, gains: [0.6, 0.6, 0.0, 0.0], shape: [0.03, 1.0] };
/// let fast = Motion { velocity: 3.0, ..Motion::default() };
/// let force: f64 = film.step(&mut EffectState::default(), &fast);
/// assert!((force - 0.6).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SublinearViscous;

impl Describe for SublinearViscous {
    const ABOUT: About = About {
        id: "sublinear_viscous",
        says: "Friction grows with speed at first, then levels off.",
        equation: "s*force*(1 - exp(-(|v|/v_0)^power))",
        shows: "odd in v, steep at low speed: friction falls toward rest",
        confused_with: "stribeck with the other sign (the same curve if a Coulomb level is free, hence both gains are positive), quadratic_drag (.80-.93)",
        told_apart_by: "constant speeds over two decades",
        gains: &[
            Parameter::gain("force_p", Dimension::FORCE, (0.0, 1e6), "friction gained at high speed in positive motion"),
            Parameter::gain("force_n", Dimension::FORCE, (0.0, 1e6), "friction gained at high speed in negative motion"),
        ],
        groups: BY_DIRECTION,
        shape: &[
            Parameter::shape("v_0", Scale::Speed, (1e-6, 1e2), "speed at which it levels off"),
            Parameter::shape("power", Scale::Range, (0.2, STEEPEST), "power of the speed below v_0"),
        ],
        reads: &[Quantity::Velocity],
        opposes_motion: true,
        example: Some(Example { gains: [0.6, 0.6, 0.0, 0.0], shape: [0.03, 1.0] }),
        ..About::EFFECT
    };
}

impl Signature for SublinearViscous {
    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [v_0, power] = *shape;
        let v = motion.velocity;
        let risen = S::one() - (-(v.abs() / v_0).powf(power)).exp();
        by_direction(v, v.sgn() * risen)
    }
}
