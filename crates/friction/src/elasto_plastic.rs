//! Elasto-plastic friction: LuGre with an elastic range, which removes its drift.

use crate::{FrictionLaw, Invalid, LuGre, Motion, Scalar, in_range, limits, mean_decay};
use serde::{Deserialize, Serialize};

/// Number of parts of a plastic displacement. The error from holding α falls with their square.
const PARTS: usize = 3;

described! {
    /// Elasto-plastic friction [dupont-2002].
    ///
    /// ```text
    /// dz/dt = v (1 − α(z, v) z/z_ss(v)),   z_ss = s g(v)/σ₀,   g(v) = F_c + (F_s − F_c) exp(−(v/v_s)²)
    /// α = 0                                      |z| ≤ z_ba, or z and v point apart
    /// α = ½ + ½ sin(π (|z| − (|z_ss| + z_ba)/2)/(|z_ss| − z_ba))   between
    /// α = 1                                      |z| ≥ |z_ss|
    /// F = σ₀ z + σ₁ dz/dt + σ₂ v
    /// ```
    ///
    /// Below z_ba = `elastic`·F_c/σ₀ the contact is a spring. A load that vibrates below that level does not move it, where
    /// Dahl's and the LuGre model drift. Elastic displacement is followed exactly. Plastic displacement is divided into parts
    /// with constant α, each solved by its exponential; |z| ≤ |z_ss| always, and any step is stable.
    ///
    /// ```
    /// use friction::{ElastoPlastic, ElastoPlasticState, FrictionLaw, LuGre, Motion};
    /// let lugre = LuGre { sigma_0: 1e5, sigma_1: 0.0, sigma_2: 0.0, coulomb: 1.0, stiction: 1.0, stribeck_velocity: 1e-3 };
    /// let law = ElastoPlastic::of(lugre, 0.8);
    /// let mut state = ElastoPlasticState::default();
    /// let there = Motion { dt: 1e-3, displacement: 7e-6, ..Motion::default() };
    /// let back = Motion { dt: 1e-3, displacement: -7e-6, ..Motion::default() };
    /// assert!((law.step(&mut state, &there) - 0.7_f64).abs() < 1e-12); // below z_ba: the spring σ₀
    /// assert!(law.step(&mut state, &back).abs() < 1e-12); // and all of it returns
    /// ```
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
        /// Stiction F_s, N. At least `coulomb`.
        pub stiction: S,
        /// Stribeck velocity v_s, m/s.
        pub stribeck_velocity: S,
        /// Elastic range as a share of F_c, 0 to 0.99. With 0 and α ≡ 1 the model would be LuGre.
        pub elastic: S,
    }
}

/// State of [`ElastoPlastic`].
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
    /// The law with the parameters of a LuGre contact and the elastic range `elastic`, as a share of F_c.
    pub fn of(lugre: LuGre<S>, elastic: S) -> Self {
        let LuGre { sigma_0, sigma_1, sigma_2, coulomb, stiction, stribeck_velocity } = lugre;
        Self { sigma_0, sigma_1, sigma_2, coulomb, stiction, stribeck_velocity, elastic }
    }

    /// The bristles without their elastic range.
    pub(crate) fn bristles(&self) -> LuGre<S> {
        let Self { sigma_0, sigma_1, sigma_2, coulomb, stiction, stribeck_velocity, elastic: _ } = *self;
        LuGre { sigma_0, sigma_1, sigma_2, coulomb, stiction, stribeck_velocity }
    }

    /// Steady friction level g(v) without the viscous part, N.
    ///
    /// ```
    /// # let lugre = friction::LuGre {
    /// #     sigma_0: 1e5, sigma_1: 0.0, sigma_2: 0.0, coulomb: 1.0, stiction: 1.5, stribeck_velocity: 1e-3,
    /// # };
    /// let law = friction::ElastoPlastic::of(lugre, 0.8);
    /// assert_eq!((law.level(0.0), law.level(1.0)), (1.5, 1.0));
    /// ```
    pub fn level(&self, velocity: S) -> S {
        limits::stribeck(self.coulomb, self.stiction, velocity, self.stribeck_velocity)
    }

    /// Deflection after sliding `distance` ≥ 0: its parts in the direction of motion and across it. On a line the second is
    /// zero.
    ///
    /// In the plane the plastic rate is dz/ds = n − α (z·n)₊/|z| z/z_ss: on the circle |z| = z_ss the deflection turns
    /// towards the motion and stays on it.
    pub(crate) fn slid(&self, z: S, side: S, distance: S, steady: S) -> (S, S) {
        let (zero, one, half) = (S::zero(), S::one(), S::lit(0.5));
        let break_away = (self.elastic * self.coulomb / self.sigma_0).min(steady);
        // where the path leaves the elastic range
        let edge = if side == zero {
            break_away
        } else {
            let share = (side / break_away).abs().min(one);
            break_away * ((one - share) * (one + share)).sqrt()
        };
        let springs = (edge - z).max(zero).min(distance);
        let (mut z, mut side, mut left) = (z + springs, side, distance - springs);
        if !(left > zero) {
            return (z, side);
        }
        if !(steady > zero) {
            return (steady, zero);
        }
        // after a few z_ss the contact has forgotten its past
        left = left.min(S::lit(64.0) * steady);
        let part = left * S::lit(1.0 / PARTS as f64);
        // divide once: a division costs a microcontroller as much as ten products
        let stiff = one / steady;
        let transition = S::lit(core::f64::consts::PI) / (steady - break_away);
        let centre = half * (steady + break_away);
        // no square of a deflection underflows where it could matter
        let length = |z: S, side: S| if side == zero { z.abs() } else { (z * z + side * side).sqrt() };
        // α/z_ss times the share of the deflection that points in the direction of motion
        let rate_at = |z: S, side: S| {
            let length = length(z, side);
            // without a division on a line
            let along = |z: S| if side == zero { one } else { z / length };
            if !(z > zero) || length <= break_away {
                zero
            } else if length >= steady {
                stiff * along(z)
            } else {
                stiff * (half + half * (transition * (length - centre)).sin_of_quarter()) * along(z)
            }
        };
        let mut rate = rate_at(z, side);
        for _ in 0..PARTS {
            // α at the middle of the part, found with the α of the previous part
            let to_middle = half * part;
            rate = rate_at(z + to_middle * (one - rate * z), side - to_middle * (rate * side));
            let decay = mean_decay(rate * part);
            (z, side) = (z + (one - rate * z) * part * decay, side - rate * side * part * decay);
            let length = length(z, side);
            if length > steady {
                (z, side) = (z / length * steady, side / length * steady);
            }
        }
        (z, side)
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
            sign * self.slid((sign * before).min(steady.max(zero)), zero, dx.abs(), steady).0
        };
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
        in_range("stribeck_velocity", self.stribeck_velocity, 1e-6, 1e3)?;
        in_range("elastic", self.elastic, 0.0, 0.99)
    }
}
