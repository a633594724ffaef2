//! LuGre friction: damped bristles whose level falls from stiction to Coulomb friction with speed.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

described! {
    /// LuGre friction [canudas-de-wit-1995].
    ///
    /// ```text
    /// dz/dt = v − σ₀ |v| z / g(v),   g(v) = F_c + (F_s − F_c) exp(−(v/v_s)²)
    /// F = σ₀ z + σ₁ dz/dt + σ₂ v
    /// ```
    ///
    /// With v and g held over a step, z has a closed solution in the distance slid; dz/dt is its mean over the step. Any step
    /// length is stable, and |z| ≤ F_s/σ₀ up to rounding.
    ///
    /// The law is passive if and only if σ₂ ≥ σ₁ (F_s − F_c)/F_c [barabanov-2000], see [`LuGre::is_passive`]. Otherwise the
    /// bristle damping can return energy while the body slides. Like Dahl's model it drifts under a vibrating load.
    ///
    /// ```
    /// use friction::{FrictionLaw, LuGre, LuGreState, Motion};
    /// let law = LuGre { sigma_0: 1e5, sigma_1: 0.0, sigma_2: 0.4, coulomb: 1.0, stiction: 1.5, stribeck_velocity: 1e-3 };
    /// let mut state = LuGreState::default();
    /// let mut force: f64 = 0.0;
    /// for _ in 0..1000 {
    ///     let slow = Motion { dt: 1e-3, displacement: 1e-6, velocity: 1e-3, ..Motion::default() };
    ///     force = law.step(&mut state, &slow);
    /// }
    /// // steady sliding at the Stribeck velocity: g(v_s) = 1 + 0.5/e, plus the viscous part
    /// assert!((force - (1.0 + 0.5 * (-1.0_f64).exp() + 0.4e-3)).abs() < 1e-9);
    /// ```
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
        /// Stiction F_s, N. At least `coulomb`.
        pub stiction: S,
        /// Stribeck velocity v_s, m/s.
        pub stribeck_velocity: S,
    }
}

/// State of [`LuGre`].
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
    /// Steady friction level g(v) without the viscous part, N.
    ///
    /// ```
    /// # let law = friction::LuGre {
    /// #     sigma_0: 1e5, sigma_1: 0.0, sigma_2: 0.4, coulomb: 1.0, stiction: 1.5, stribeck_velocity: 1e-3,
    /// # };
    /// assert_eq!((law.level(0.0), law.level(1.0)), (1.5, 1.0)); // from stiction at rest to Coulomb friction
    /// ```
    pub fn level(&self, velocity: S) -> S {
        limits::stribeck(self.coulomb, self.stiction, velocity, self.stribeck_velocity)
    }

    /// Compliance of the bristles 1/σ₀, and 1/v_s. One division instead of two: a division costs a microcontroller as much
    /// as ten products.
    #[inline(always)]
    pub(crate) fn inverses(&self) -> (S, S) {
        let inverse = S::one() / (self.sigma_0 * self.stribeck_velocity);
        (inverse * self.stribeck_velocity, inverse * self.sigma_0)
    }

    /// Share of a deflection's distance from its end that is left after sliding −`slid`, at the level g.
    #[inline(always)]
    pub(crate) fn left(&self, slid: S, level: S) -> S {
        if level > S::zero() { (self.sigma_0 * slid / level).exp_inlined() } else { S::zero() }
    }

    /// Whether the law is passive, that is never returns more energy than it received: σ₂ F_c ≥ σ₁ (F_s − F_c).
    ///
    /// ```
    /// # let law = friction::LuGre {
    /// #     sigma_0: 1e5, sigma_1: 0.0, sigma_2: 0.4, coulomb: 1.0, stiction: 1.5, stribeck_velocity: 1e-3,
    /// # };
    /// assert!(law.is_passive());
    /// assert!(!friction::LuGre { sigma_1: 300.0, ..law }.is_passive());
    /// ```
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
        let (compliance, inverse_v_s) = self.inverses();
        let bound = self.stiction * compliance;
        let before = state.z.clamp(-bound, bound);
        if dx == zero {
            state.z = before;
        } else {
            let ratio = motion.velocity * inverse_v_s;
            let level = limits::stribeck_at(self.coulomb, self.stiction, ratio);
            let (end, slid) = if dx > zero { (level, -dx) } else { (-level, dx) };
            let end = end * compliance;
            state.z = end + (before - end) * self.left(slid, level);
        }
        let rate = if motion.dt > zero { limits::bounded((state.z - before) / motion.dt) } else { zero };
        limits::bounded(self.sigma_0 * state.z + self.sigma_1 * rate + self.sigma_2 * motion.velocity)
    }

    fn stored(&self, state: &Self::State) -> S {
        S::lit(0.5) * self.sigma_0 * state.z * state.z
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
