//! Karnopp's friction, modified for different friction in the two directions (thesis eq. 3.1).

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// Modified Karnopp friction, eq. 3.1. All levels are magnitudes (the thesis prints C_n and D_n negative).
///
/// ```text
/// v >  Δv   F =  C_p + b_p v
/// v < −Δv   F = −C_n + b_n v
/// |v| ≤ Δv  F = the force that brings the body to rest, within [−D_n, D_p]
/// ```
///
/// Printed, the stuck branch is `min(D_p, F_a)` or `max(D_n, F_a)` by the sign of v, which says nothing at
/// v = 0, leaves the force unbounded when F_a opposes v, and lets a body that entered the band at 0.9 Δv
/// creep on at 0.9 Δv. Here the band is one branch with both limits, and it *stops* the body where the mass
/// is known: F = clamp(m v / dt + F_a, −D_n, D_p). With `mass = 0` it balances F_a as printed.
///
/// The sliding branch is as printed, so it has Karnopp's zero-crossing limit cycle when Δv is too small for the
/// time step (C dt / m > 2 Δv for a free mass; eq. 4.21 for a rendered one); [`crate::Coulomb`] has none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Karnopp<S> {
    /// Dynamic friction in positive motion, C_p, N.
    pub c_p: S,
    /// Dynamic friction in negative motion, magnitude of C_n, N.
    pub c_n: S,
    /// Viscous friction in positive motion, b_p, N·s/m. Negative where friction falls with speed (brass).
    pub b_p: S,
    /// Viscous friction in negative motion, b_n, N·s/m.
    pub b_n: S,
    /// Static friction against positive motion, D_p, N.
    pub d_p: S,
    /// Static friction against negative motion, magnitude of D_n, N.
    pub d_n: S,
    /// Speed below which the velocity is taken for zero, Δv, m/s.
    pub delta_v: S,
}

impl<S: Scalar> Karnopp<S> {
    /// Whether eq. 3.1 takes this velocity for zero.
    pub fn is_stuck(&self, velocity: S) -> bool {
        velocity <= self.delta_v && velocity >= -self.delta_v
    }
}

impl<S: Scalar> FrictionLaw<S> for Karnopp<S> {
    type State = ();

    #[inline(always)] // part of nearly every control step
    fn step(&self, (): &mut (), motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let v = motion.velocity;
        limits::bounded(if self.is_stuck(v) {
            motion.stopping_force().clamp(-self.d_n, self.d_p)
        } else if v > S::zero() {
            limits::sliding(self.c_p, self.b_p, v)
        } else {
            -limits::sliding(self.c_n, self.b_n, -v)
        })
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("c_p", self.c_p, 0.0, limits::LEVEL)?;
        in_range("c_n", self.c_n, 0.0, limits::LEVEL)?;
        in_range("b_p", self.b_p, -limits::VISCOUS, limits::VISCOUS)?;
        in_range("b_n", self.b_n, -limits::VISCOUS, limits::VISCOUS)?;
        in_range("d_p", self.d_p, 0.0, limits::LEVEL)?;
        in_range("d_n", self.d_n, 0.0, limits::LEVEL)?;
        in_range("delta_v", self.delta_v, 0.0, 10.0)
    }
}
