//! Elasto-plastic friction: LuGre whose bristles are springs before they slip, so that it does not drift.

use crate::{FrictionLaw, Invalid, LuGre, Motion, Scalar, in_range, limits, mean_decay};
use serde::{Deserialize, Serialize};

/// Parts a plastic displacement is cut into at most; the error of the frozen α falls with their square.
const PARTS: usize = 3;

/// Elasto-plastic friction (Dupont, Hayward, Armstrong, Altpeter 2002).
///
/// ```text
/// dz/dt = v (1 − α(z, v) z/z_ss(v)),   z_ss = s g(v)/σ₀,   g(v) = F_c + (F_s − F_c) exp(−(v/v_s)²)
/// α = 0                                      |z| ≤ z_ba, or z and v point apart
/// α = ½ + ½ sin(π (|z| − (|z_ss| + z_ba)/2)/(|z_ss| − z_ba))   between
/// α = 1                                      |z| ≥ |z_ss|
/// F = σ₀ z + σ₁ dz/dt + σ₂ v
/// ```
///
/// Below z_ba = `elastic`·F_c/σ₀ the contact is a spring and gives everything back: a load that vibrates below that does not
/// move it, where Dahl and LuGre drift. Elastic displacement is followed exactly; plastic in parts with α held over
/// each, by the exponential that solves it, so that |z| ≤ |z_ss| always and any step is stable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ElastoPlastic<S> {
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
    /// Share of F_c up to which the contact is a spring, 0 … 0.99; 0 with α ≡ 1 would be LuGre.
    pub elastic: S,
}

/// What [`ElastoPlastic`] remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElastoPlasticState<S> {
    /// Mean deflection of the bristles z, m.
    pub z: S,
}

impl<S: Scalar> Default for ElastoPlasticState<S> {
    fn default() -> Self {
        Self { z: S::zero() }
    }
}

impl<S: Scalar> ElastoPlastic<S> {
    /// The bristles of a LuGre contact, springs up to this share of F_c.
    pub fn of(lugre: LuGre<S>, elastic: S) -> Self {
        let LuGre { sigma_0, sigma_1, sigma_2, coulomb, stiction, stribeck_velocity } = lugre;
        Self { sigma_0, sigma_1, sigma_2, coulomb, stiction, stribeck_velocity, elastic }
    }

    /// Steady friction level g(v) without its viscous part, N.
    pub fn level(&self, velocity: S) -> S {
        limits::stribeck(self.coulomb, self.stiction, velocity, self.stribeck_velocity)
    }

    /// The deflection, counted along the motion, after sliding `distance` ≥ 0.
    fn slid(&self, z: S, distance: S, steady: S) -> S {
        let zero = S::zero();
        let break_away = (self.elastic * self.coulomb / self.sigma_0).min(steady);
        let springs = (break_away - z).max(zero).min(distance);
        let (mut z, mut left) = (z + springs, distance - springs);
        if !(left > zero) {
            return z;
        }
        if !(steady > zero) {
            return steady;
        }
        // within a few z_ss the contact has forgotten where it was
        left = left.min(S::lit(64.0) * steady);
        let (one, half) = (S::one(), S::lit(0.5));
        let part = left * S::lit(1.0 / PARTS as f64);
        // divisions once: each costs a microcontroller as much as ten products
        let stiff = one / steady;
        let transition = S::lit(core::f64::consts::PI) / (steady - break_away);
        let centre = half * (steady + break_away);
        // α/z_ss of a deflection that points where the motion goes
        let rate_at = |z: S| {
            if z <= break_away {
                zero
            } else if z >= steady {
                stiff
            } else {
                stiff * (half + half * (transition * (z - centre)).sin())
            }
        };
        let mut rate = rate_at(z);
        for _ in 0..PARTS {
            // α in the middle of the part, which the α of the part before is good enough to find
            rate = rate_at(z + half * part * (one - rate * z));
            z = (z + (one - rate * z) * part * mean_decay(rate * part)).min(steady);
        }
        z
    }
}

impl<S: Scalar> FrictionLaw<S> for ElastoPlastic<S> {
    type State = ElastoPlasticState<S>;

    fn step(&self, state: &mut ElastoPlasticState<S>, motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let (dx, zero) = (motion.displacement, S::zero());
        let bound = self.stiction / self.sigma_0;
        let before = state.z.clamp(-bound, bound);
        state.z = if dx == zero {
            before
        } else {
            let (sign, steady) = (dx.sgn(), self.level(motion.velocity) / self.sigma_0);
            sign * self.slid((sign * before).min(steady.max(zero)), dx.abs(), steady)
        };
        let rate = if motion.dt > zero { limits::bounded((state.z - before) / motion.dt) } else { zero };
        limits::bounded(self.sigma_0 * state.z + self.sigma_1 * rate + self.sigma_2 * motion.velocity)
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("sigma_0", self.sigma_0, 1e-3, limits::STIFFNESS)?;
        in_range("sigma_1", self.sigma_1, 0.0, limits::VISCOUS)?;
        in_range("sigma_2", self.sigma_2, 0.0, limits::VISCOUS)?;
        in_range("coulomb", self.coulomb, 0.0, limits::LEVEL)?;
        in_range("stiction", self.stiction, self.coulomb.re(), limits::LEVEL)?;
        in_range("stribeck_velocity", self.stribeck_velocity, 1e-6, 1e3)?;
        in_range("elastic", self.elastic, 0.0, 0.99)
    }
}
