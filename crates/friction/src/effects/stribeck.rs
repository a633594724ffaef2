//! Friction that falls as the body starts to slide: boundary lubrication giving way to a film.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature, by_direction};
use super::{About, Describe, Parameter, BY_DIRECTION, Example, Quantity, Scale};
use crate::{Dimension, Motion, Scalar};

/// The Stribeck effect.
///
/// F = s·force·exp(−(|v|/v_s)^delta), s = sgn v; by direction. Zero at rest, where a law holds the body: the break-away
/// level is the law's, not this effect's.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let rise = Effect { kind: EffectKind::Stribeck, gains: [0.5, 0.4, 0.0, 0.0], shape: [0.02, 1.0] };
/// let slow = Motion { velocity: -0.02, ..Motion::default() };
/// let force: f64 = rise.step(&mut EffectState::default(), &slow);
/// assert!((force + 0.4 / std::f64::consts::E).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stribeck;

impl Describe for Stribeck {
    const ABOUT: About = About {
        id: "stribeck",
        says: "Friction is higher at very low speed and falls as sliding gets faster.",
        equation: "s*force*exp(-(|v|/v_s)^delta)",
        shows: "odd in v, only at low speed, the same whether the body speeds up or slows down",
        confused_with: "sublinear_viscous with the other sign (.74-.89), presliding",
        told_apart_by: "a staircase of slow constant speeds, where presliding has died out",
        gains: &[
            Parameter::gain("force_p", Dimension::FORCE, (0.0, 1e6), "rise of friction toward rest in positive motion"),
            Parameter::gain("force_n", Dimension::FORCE, (0.0, 1e6), "rise of friction toward rest in negative motion"),
        ],
        groups: BY_DIRECTION,
        shape: &[
            Parameter::shape("v_s", Scale::Speed, (1e-6, 1e2), "speed at which the rise has fallen to 1/e"),
            Parameter::shape("delta", Scale::Range, (0.3, 4.0), "sharpness of the fall: 1 exponential, 2 Gaussian"),
        ],
        reads: &[Quantity::Velocity],
        opposes_motion: true,
        example: Some(Example { gains: [0.5, 0.5, 0.0, 0.0], shape: [0.02, 1.0] }),
        ..About::EFFECT
    };
}

impl Signature for Stribeck {
    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [v_s, delta] = *shape;
        let v = motion.velocity;
        let falling = (-(v.abs() / v_s).powf(delta)).exp();
        by_direction(v, v.sgn() * falling)
    }
}
