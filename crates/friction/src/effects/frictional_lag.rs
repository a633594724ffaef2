//! Friction follows the velocity late (frictional memory, Hess and Soom; the lag in Armstrong's seven parameters).
//!
//! u lags v by a first-order filter of time constant `lag`, which delays a ramp by exactly `lag`.
//! F = force·(sgn u − sgn v) + stribeck·s·(exp(−|u|/v_s) − exp(−|v|/v_s)), s = sgn v: what F(v(t − T)) has beyond F(v) for a
//! Coulomb and a Stribeck part. A lagging viscous part is a mass (−b·T·a) and cannot be seen beside one.
//!
//! * Signature: an F-v loop that widens with acceleration, in time and not in distance.
//! * Confused with: velocity_lag of the estimator (1.0 on one sine), presliding (.89).
//! * Told apart by: moves with dwells; recomputing the velocity from the position.
//! * Rendering: for `lag` after a reversal the `force` part drives instead of braking, so it is not passive.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature};
use crate::{Motion, Scalar, mean_decay};

/// Frictional lag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrictionalLag;

impl Signature for FrictionalLag {
    const ID: &'static str = "frictional_lag";
    const SAYS: &'static str = "Friction reacts to a change of speed a moment late.";
    const EQUATION: &'static str =
        "force*(sgn(u) - s) + stribeck*s*(exp(-|u|/v_s) - exp(-|v|/v_s)), du/dt = (v - u)/lag";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("force", "N", (0.0, 1e6), "Coulomb friction that reverses late"),
        Parameter::new("stribeck", "N", (0.0, 1e6), "low-speed friction that follows late"),
    ];
    const SHAPE: &'static [Parameter] = &[
        Parameter::new("lag", "s", (1e-6, 10.0), "how late"),
        Parameter::new("v_s", "m/s", (1e-6, 1e2), "speed at which low-speed friction has fallen to 1/e"),
    ];

    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [lag, v_s] = *shape;
        let [u, started, before, ..] = memory;
        let (v, zero) = (motion.velocity, S::zero());
        let mut change = zero;
        // in units of the lag; a time too short for it to be a number is none
        let x = motion.dt / lag;
        if *started == zero {
            *u = v; // a recording may begin in motion
            *started = S::one();
        } else if x > zero {
            // exact for a velocity that is straight between samples: held, it would come half a sample less late
            let keep = (-x).exp();
            *u = keep * (*u - *before) + v - (v - *before) * mean_decay(x);
            change = ((v - *u) * x).abs();
        }
        *before = v;
        let falling = |speed: S| (-(speed.abs() / v_s)).exp();
        // the mean of sgn u over the sample: the moment at which it turns is known better than to a sample
        let twice = *u + *u;
        let sign = if twice.abs() < change { twice / change } else { u.sgn() };
        [sign - v.sgn(), v.sgn() * (falling(*u) - falling(v)), zero, zero]
    }
}
