//! Play in series with friction: after a reversal the slider stays where it is until the play is taken up.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, BY_DIRECTION, Describe, EffectKind, Example, Parameter, Quantity, Scale, Seat};
use crate::{Dimension, Motion, Scalar};

/// Share of `x_s` below which a gap is no stretch without force but a part of the elastic turn-round.
const SHORT: f64 = 0.25;

/// A gap, then the stiffness behind it, then friction.
///
/// The deflection d of the drive against the slider grows with the motion and is limited to |d| ≤ gap/2 + x_s, where the
/// slider follows. φ(d) is 0 for |d| < gap/2, then (|d| − gap/2)/x_s with the sign of d. Friction behind the play is
/// level·φ in place of level·s: F = level·(φ − s), by direction, beside a law that has level·s already. s = sgn v; at rest
/// the direction of the applied force, so that nothing holds a body inside the gap. Where the law's own friction is
/// level·s the sum is a spring with a dead zone that slips: it stores no more than level·x_s/2.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let play = Effect { kind: EffectKind::LostMotion, gains: [3.0, 3.0, 0.0, 0.0], shape: [2e-3, 1e-3] };
/// let mut state = EffectState::default();
/// let slide = |displacement: f64| Motion { velocity: displacement, displacement, ..Motion::default() };
/// let total = |force: f64, s: f64| force + 3.0 * s; // with Coulomb friction of that level
/// assert_eq!(total(play.step(&mut state, &slide(5e-3)), 1.0), 3.0); // N: the slider slides
/// assert!((total(play.step(&mut state, &slide(-5e-4)), -1.0) - 1.5).abs() < 1e-12); // half of x_s given back
/// assert!(total(play.step(&mut state, &slide(-1.5e-3)), -1.0).abs() < 1e-12); // inside the gap
/// assert_eq!(total(play.step(&mut state, &slide(-2e-3)), -1.0), -3.0); // taken along the other way
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LostMotion;

impl Describe for LostMotion {
    const ABOUT: About = About {
        id: "lost_motion",
        says: "After each reversal there is a stretch without friction: a play has to be taken up before the slider follows.",
        equation: "level*(phi(d) - s), phi = 0 for |d| < gap/2, then (|d| - gap/2)/x_s up to 1, |d| <= gap/2 + x_s",
        shows: "friction near zero over a distance after each reversal, then a snap to its level, at any speed",
        confused_with: "presliding, backlash (there the load is behind the play)",
        told_apart_by: "strokes shorter and longer than the gap",
        gains: &[
            Parameter::gain("level_p", Dimension::FORCE, (0.0, 1e6), "friction behind the play in positive motion"),
            Parameter::gain("level_n", Dimension::FORCE, (0.0, 1e6), "friction behind the play in negative motion"),
        ],
        groups: BY_DIRECTION,
        shape: &[
            Parameter::shape("gap", Scale::Distance, (1e-8, 1e2), "distance without force"),
            Parameter::shape("x_s", Scale::Distance, (1e-8, 1e2), "distance behind the gap over which the force rises"),
        ],
        reads: &[Quantity::Displacement, Quantity::Velocity, Quantity::Force],
        seat: Seat::Drive,
        example: Some(Example { gains: [0.5, 0.5, 0.0, 0.0], shape: [8e-4, 2e-4] }),
        ..About::EFFECT
    };
}

impl Signature for LostMotion {
    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [gap, x_s] = *shape;
        let [d, ..] = memory;
        let (zero, one) = (S::zero(), S::one());
        let half = S::lit(0.5) * gap;
        let most = half + x_s;
        *d = (*d + motion.displacement).clamp(-most, most);
        let beyond = *d - (*d).clamp(-half, half);
        let phi = (beyond / x_s).clamp(-one, one);
        let direction = if motion.velocity == zero { motion.applied } else { motion.velocity };
        let s = direction.sgn();
        // each side of the dead zone has the level of the direction that bends it: no step where the motion turns
        [phi.max(zero) - s.max(zero), phi.min(zero) - s.min(zero), zero, zero]
    }

    fn rather([gap, x_s]: &[f64; MAX_SHAPE]) -> Option<EffectKind> {
        (*gap < SHORT * x_s).then_some(EffectKind::Presliding)
    }
}
