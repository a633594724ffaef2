//! LuGre friction: bristles with damping, and a level that falls from stiction to Coulomb with speed.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// LuGre friction (Canudas de Wit, Olsson, Åström, Lischinsky 1995).
///
/// ```text
/// dz/dt = v − σ₀ |v| z / g(v),   g(v) = F_c + (F_s − F_c) exp(−(v/v_s)²)
/// F = σ₀ z + σ₁ dz/dt + σ₂ v
/// ```
///
/// Over a step v and g are held, so z has a closed solution in the distance slid; dz/dt is its mean over the step.
/// Any step length is stable and |z| ≤ F_s/σ₀ always, to rounding.
///
/// Passive if and only if σ₂ ≥ σ₁ (F_s − F_c)/F_c (Barabanov and Ortega 2000), see [`LuGre::is_passive`]; beyond that
/// bristle damping can give energy back while the body slides. Like Dahl it drifts under a vibrating load.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LuGre<S> {
    /// Bristle stiffness σ₀, N/m.
    pub sigma_0: S,
    /// Bristle damping σ₁, N·s/m.
    pub sigma_1: S,
    /// Viscous friction σ₂, N·s/m.
    pub sigma_2: S,
    /// Coulomb level F_c, N.
    pub coulomb: S,
    /// Stiction F_s, N; at least `coulomb`.
    pub stiction: S,
    /// Stribeck velocity v_s, m/s.
    pub stribeck_velocity: S,
}

/// What [`LuGre`] remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LuGreState<S> {
    /// Mean deflection of the bristles z, m.
    pub z: S,
}

impl<S: Scalar> Default for LuGreState<S> {
    fn default() -> Self {
        Self { z: S::zero() }
    }
}

impl<S: Scalar> LuGre<S> {
    /// Steady friction level g(v) without its viscous part, N.
    pub fn level(&self, velocity: S) -> S {
        limits::stribeck(self.coulomb, self.stiction, velocity, self.stribeck_velocity)
    }

    /// Whether the law can never give back more energy than it was given: σ₂ F_c ≥ σ₁ (F_s − F_c).
    pub fn is_passive(&self) -> bool {
        self.sigma_2 * self.coulomb >= self.sigma_1 * (self.stiction - self.coulomb)
    }
}

impl<S: Scalar> FrictionLaw<S> for LuGre<S> {
    type State = LuGreState<S>;

    fn step(&self, state: &mut LuGreState<S>, motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let (dx, zero) = (motion.displacement, S::zero());
        // one division for two: each costs a microcontroller as much as ten products
        let inverse = S::one() / (self.sigma_0 * self.stribeck_velocity);
        let compliance = inverse * self.stribeck_velocity;
        let bound = self.stiction * compliance;
        let before = state.z.clamp(-bound, bound);
        if dx == zero {
            state.z = before;
        } else {
            let ratio = motion.velocity * (inverse * self.sigma_0);
            let level = limits::stribeck_at(self.coulomb, self.stiction, ratio);
            let (end, slid) = if dx > zero { (level, -dx) } else { (-level, dx) };
            let end = end * compliance;
            let left = if level > zero { (self.sigma_0 * slid / level).exp() } else { zero };
            state.z = end + (before - end) * left;
        }
        let rate = if motion.dt > zero { limits::bounded((state.z - before) / motion.dt) } else { zero };
        limits::bounded(self.sigma_0 * state.z + self.sigma_1 * rate + self.sigma_2 * motion.velocity)
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("sigma_0", self.sigma_0, 1e-3, limits::STIFFNESS)?;
        in_range("sigma_1", self.sigma_1, 0.0, limits::VISCOUS)?;
        in_range("sigma_2", self.sigma_2, 0.0, limits::VISCOUS)?;
        in_range("coulomb", self.coulomb, 0.0, limits::LEVEL)?;
        in_range("stiction", self.stiction, self.coulomb.re(), limits::LEVEL)?;
        in_range("stribeck_velocity", self.stribeck_velocity, 1e-6, 1e3)
    }
}
