//! Friction that falls as the body starts to slide: boundary lubrication giving way to a film.
//!
//! F = s·force·exp(−(|v|/v_s)^delta), s = sgn v; by direction. Zero at rest, where a law holds the body: the break-away
//! level is the law's, not this effect's.
//!
//! * Signature: odd in v, only at low speed, the same whether the body speeds up or slows down.
//! * Confused with: sublinear_viscous with the other sign (cosine .74-.89), presliding.
//! * Told apart by: a staircase of slow constant speeds, where presliding has died out.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature, by_direction};
use crate::{Motion, Scalar};

/// The Stribeck effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stribeck;

impl Signature for Stribeck {
    const ID: &'static str = "stribeck";
    const SAYS: &'static str = "Friction is higher at very low speed and falls as sliding gets faster.";
    const EQUATION: &'static str = "s*force*exp(-(|v|/v_s)^delta)";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("force_p", "N", (0.0, 1e6), "rise of friction toward rest in positive motion"),
        Parameter::new("force_n", "N", (0.0, 1e6), "rise of friction toward rest in negative motion"),
    ];
    const SHAPE: &'static [Parameter] = &[
        Parameter::new("v_s", "m/s", (1e-6, 1e2), "speed at which the rise has fallen to 1/e"),
        Parameter::new("delta", "1", (0.3, 4.0), "sharpness of the fall: 1 exponential, 2 Gaussian"),
    ];

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
