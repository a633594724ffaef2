//! Bounds shared by the laws: ranges of parameters and of forces.

use crate::Scalar;

/// Largest friction level, N: above anything on a bench, and exact enough in `f32`.
pub(crate) const LEVEL: f64 = 1e6;
/// Largest viscous coefficient, N·s/m.
pub(crate) const VISCOUS: f64 = 1e6;
/// Largest stiffness, N/m.
pub(crate) const STIFFNESS: f64 = 1e12;
/// Largest force any law returns, N. A finite motion gives a finite force even where b·v would overflow.
const FORCE: f64 = 1e30;

/// Force limited to [`FORCE`], which `f32` can represent.
pub(crate) fn bounded<S: Scalar>(force: S) -> S {
    force.clamp(S::lit(-FORCE), S::lit(FORCE))
}

/// Level plus viscous friction at `speed` ≥ 0, never below zero. With a negative coefficient the line would cross zero at
/// high speed, and friction would drive.
pub(crate) fn sliding<S: Scalar>(level: S, viscous: S, speed: S) -> S {
    (level + viscous * speed).max(S::zero())
}

/// Stribeck curve from `stiction` at rest to `coulomb`: g(v) = F_c + (F_s − F_c) exp(−(v/v_s)²).
pub(crate) fn stribeck<S: Scalar>(coulomb: S, stiction: S, velocity: S, stribeck_velocity: S) -> S {
    let ratio = velocity / stribeck_velocity;
    coulomb + (stiction - coulomb) * fallen(ratio).exp()
}

/// Logarithm of the rest of the Stribeck friction at `ratio` = v/v_s.
#[inline(always)]
fn fallen<S: Scalar>(ratio: S) -> S {
    -(ratio * ratio).min(S::lit(1e6))
}

/// Stribeck curve at `ratio` = v/v_s, without a call.
#[inline(always)]
pub(crate) fn stribeck_at<S: Scalar>(coulomb: S, stiction: S, ratio: S) -> S {
    coulomb + (stiction - coulomb) * fallen(ratio).exp_inlined()
}
