//! Friction that follows the velocity late.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, Describe, Parameter, Example, FIRST_OR_BOTH, Quantity, Scale};
use crate::{Dimension, Motion, Scalar, mean_decay};

/// Frictional memory (Hess and Soom 1990), the lag in Armstrong's seven parameters: a delay of the velocity.
///
/// F = force·(sgn u − sgn v) + stribeck·(sgn u·exp(−|u|/v_s) − sgn v·exp(−|v|/v_s)), u = v(t − lag): what F(u) has beyond F(v)
/// for a Coulomb and a Stribeck part. A late viscous part is a mass (−b·lag·a) and cannot be seen beside one.
///
/// No past velocities are stored. The direction turns `lag` after that of v, at rest it is the last one; one that turns back
/// before that does not turn at all. The speed |u| lags by a first-order filter, which delays a ramp by exactly `lag`.
///
/// For `lag` after a reversal the `force` part drives instead of braking, so a rendered one is not passive.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let late = Effect { kind: EffectKind::FrictionalLag, gains: [0.8, 0.0, 0.0, 0.0], shape: [0.01, 0.05] };
/// let mut state = EffectState::default();
/// let forward = Motion { dt: 1e-3, velocity: 0.1, ..Motion::default() };
/// late.step(&mut state, &forward);
/// let force: f64 = late.step(&mut state, &Motion { velocity: -0.1, ..forward });
/// assert!((force - 1.6).abs() < 1e-12); // N: right after a reversal it still pushes as before
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrictionalLag;

impl Describe for FrictionalLag {
    const ABOUT: About = About {
        id: "frictional_lag",
        says: "Friction reacts to a change of speed a moment late.",
        equation: "force*(sgn(u) - s) + stribeck*(sgn(u)*exp(-|u|/v_s) - s*exp(-|v|/v_s)), u(t) = v(t - lag)",
        shows: "an F-v loop that widens with acceleration, in time and not in distance",
        confused_with: "velocity_lag of the estimator (1.0 on one sine), presliding (.89)",
        told_apart_by: "moves with dwells; recomputing the velocity from the position",
        gains: &[
            Parameter::gain("force", Dimension::FORCE, (0.0, 1e6), "Coulomb friction that reverses late"),
            Parameter::gain("stribeck", Dimension::FORCE, (0.0, 1e6), "low-speed friction that follows late"),
        ],
        groups: FIRST_OR_BOTH,
        shape: &[
            Parameter::shape("lag", Scale::Lag, (1e-6, 10.0), "how late"),
            Parameter::shape("v_s", Scale::Speed, (1e-6, 1e2), "speed at which low-speed friction has fallen to 1/e"),
        ],
        reads: &[Quantity::Velocity, Quantity::Time],
        example: Some(Example { gains: [0.0, 0.8, 0.0, 0.0], shape: [0.01, 0.05] }),
        ..About::EFFECT
    };
}

impl Signature for FrictionalLag {
    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [lag, v_s] = *shape;
        let [u, before, way, ago] = memory;
        let (v, dt, zero) = (motion.velocity, motion.dt, S::zero());
        // in units of the lag; a time too short for it to be a number is none
        let x = dt / lag;
        let (over, turns) = (lag + dt, *way * v.sgn() < zero);
        if *way == zero {
            (*u, *way, *ago) = (v, v.sgn(), over); // a recording may begin in motion
        } else if x > zero {
            // exact for a velocity that is straight between samples: held, it would come half a sample less late
            *u = (-x).exp() * (*u - *before) + v - (v - *before) * mean_decay(x);
            // v crosses zero where the straight line does; what has not turned yet stays as it is
            *ago = if !turns { *ago + dt } else if *ago < lag { over } else { v / (v - *before) * dt };
        }
        if turns {
            *way = v.sgn();
        }
        *before = v;
        // the mean of sgn u over the sample: the moment at which it turns is known better than to a sample
        let since = (*ago - lag) * S::lit(2.0);
        let sign = *way * if since.abs() < dt { since / dt } else { since.sgn() };
        let falling = |speed: S| (-(speed.abs() / v_s)).exp();
        [sign - v.sgn(), sign * falling(*u) - v.sgn() * falling(v), zero, zero]
    }
}
