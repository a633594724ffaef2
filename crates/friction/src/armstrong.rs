//! Armstrong's integrated model: presliding spring, Coulomb, viscous, Stribeck, frictional memory, rising stiction.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// The seven-parameter model (Armstrong-Hélouvry, Dupont, Canudas de Wit 1994), section 2.4.6.
///
/// ```text
/// stuck:    F = k_t z,                  until |F| = F_C + F_S(t₂)
/// sliding:  F = [F_C + F_V |v| + F_S(γ, t₂)/(1 + (v_L/v_s)²)] sgn v
/// F_S(γ, t₂) = F_Sa + (F_S∞ − F_Sa) t₂/(t₂ + γ)
/// ```
///
/// t₂ is the dwell time, F_Sa the magnitude of the Stribeck friction at the end of the sliding before, v_L the velocity
/// with the frictional memory τ_L. Armstrong delays it by τ_L; here τ_L is the time constant of a first-order lag (the
/// thesis's word), which needs no store of past velocities. The contact sticks where the motion reverses or stops, and
/// its spring begins with the force it slid with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Armstrong<S> {
    /// Coulomb friction F_C, N.
    pub coulomb: S,
    /// Viscous friction F_V, N·s/m.
    pub viscous: S,
    /// Stribeck friction after a long time at rest F_S∞, N.
    pub stribeck: S,
    /// Tangential stiffness of the static contact k_t, N/m.
    pub stiffness: S,
    /// Characteristic velocity of the Stribeck friction v_s, m/s.
    pub stribeck_velocity: S,
    /// Time constant of the frictional memory τ_L, s.
    pub memory: S,
    /// Temporal parameter of the rising static friction γ, s.
    pub dwell: S,
}

/// What [`Armstrong`] remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmstrongState<S> {
    /// Force of the contact without its viscous part, N.
    pub spring: S,
    /// The contact slides.
    pub sliding: bool,
    /// Dwell time t₂, s.
    pub dwelt: S,
    /// Stribeck friction at break-away, F_S(γ, t₂), N.
    pub risen: S,
    /// Stribeck friction at the end of the sliding before, F_Sa, N.
    pub left: S,
    /// Velocity with the frictional memory, m/s.
    pub lagged: S,
}

impl<S: Scalar> Default for ArmstrongState<S> {
    fn default() -> Self {
        let zero = S::zero();
        Self { spring: zero, sliding: false, dwelt: zero, risen: zero, left: zero, lagged: zero }
    }
}

impl<S: Scalar> Armstrong<S> {
    /// F_S(γ, t₂), N.
    pub fn risen(&self, left: S, dwelt: S) -> S {
        let share = if dwelt > S::zero() { dwelt / (dwelt + self.dwell) } else { S::zero() };
        left + (self.stribeck - left) * share
    }
}

impl<S: Scalar> FrictionLaw<S> for Armstrong<S> {
    type State = ArmstrongState<S>;

    fn step(&self, state: &mut ArmstrongState<S>, motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let (dx, v, zero, one) = (motion.displacement, motion.velocity, S::zero(), S::one());
        let follows = if self.memory > zero { one - (-(motion.dt / self.memory)).exp() } else { one };
        state.lagged += (v - state.lagged) * follows;
        let ratio = (state.lagged / self.stribeck_velocity).clamp(S::lit(-1e6), S::lit(1e6));
        let fallen = one / (one + ratio * ratio);
        if state.sliding && dx * state.spring.sgn() <= zero {
            state.sliding = false;
            state.left = state.risen * fallen;
            state.dwelt = zero;
        }
        if !state.sliding {
            state.dwelt += motion.dt;
            let risen = self.risen(state.left, state.dwelt);
            let level = self.coulomb + risen;
            state.spring += self.stiffness * dx;
            if state.spring.abs() <= level {
                // the spring's damping is the viscous friction, so that a stuck body comes to rest
                return limits::bounded(state.spring + self.viscous * v);
            }
            state.sliding = true;
            state.risen = risen;
        }
        let level = self.coulomb + state.risen * fallen;
        state.spring = level * state.spring.sgn();
        limits::bounded(state.spring + self.viscous * v)
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("coulomb", self.coulomb, 0.0, limits::LEVEL)?;
        in_range("viscous", self.viscous, 0.0, limits::VISCOUS)?;
        in_range("stribeck", self.stribeck, 0.0, limits::LEVEL)?;
        in_range("stiffness", self.stiffness, 1e-3, limits::STIFFNESS)?;
        in_range("stribeck_velocity", self.stribeck_velocity, 1e-6, 1e3)?;
        in_range("memory", self.memory, 0.0, 1e3)?;
        in_range("dwell", self.dwell, 1e-6, 1e6)
    }
}
