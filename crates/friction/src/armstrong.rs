//! Armstrong's seven-parameter model: presliding, Coulomb, viscous, Stribeck, frictional memory, rising stiction.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

described! {
    /// The seven-parameter model [armstrong-1994] [thesis, ch. 2.4.6].
    ///
    /// ```text
    /// stuck:    F = k_t z,                  until |F| = F_C + F_S(t₂)
    /// sliding:  F = [F_C + F_V |v| + F_S(γ, t₂)/(1 + (v_L/v_s)²)] sgn v
    /// F_S(γ, t₂) = F_Sa + (F_S∞ − F_Sa) t₂/(t₂ + γ)
    /// ```
    ///
    /// t₂ is the dwell time, F_Sa the Stribeck friction at the end of the previous slide, and v_L the velocity with the
    /// frictional memory τ_L. The source delays v by τ_L; here τ_L is the time constant of a first-order lag, which needs no
    /// store of past velocities. The contact sticks where the motion reverses or stops, and its spring then starts from the
    /// sliding force.
    ///
    /// ```
    /// use friction::{Armstrong, ArmstrongState, FrictionLaw, Motion};
    /// let law = Armstrong {
    ///     coulomb: 2.0, viscous: 0.0, stribeck: 1.0, stiffness: 1e5, stribeck_velocity: 0.01, memory: 0.0, dwell: 0.1,
    /// };
    /// let mut state = ArmstrongState::default();
    /// let stuck = Motion { dt: 1e-3, displacement: 1e-5, velocity: 0.01, ..Motion::default() };
    /// assert!((law.step(&mut state, &stuck) - 1.0_f64).abs() < 1e-12); // the spring k_t
    /// let fast = Motion { dt: 1e-3, displacement: 1e-2, velocity: 10.0, ..Motion::default() };
    /// assert!((law.step(&mut state, &fast) - 2.0).abs() < 1e-6); // Coulomb friction, far above v_s
    /// ```
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
}

/// State of [`Armstrong`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmstrongState<S> {
    /// Force of the contact without the viscous part, N.
    pub spring: S,
    /// Whether the contact slides.
    pub sliding: bool,
    /// Dwell time t₂, s.
    pub dwelt: S,
    /// Stribeck friction at break-away, F_S(γ, t₂), N.
    pub risen: S,
    /// Stribeck friction at the end of the previous slide, F_Sa, N.
    pub left: S,
    /// Velocity after the frictional memory, v_L, m/s.
    pub lagged: S,
}

impl<S: Scalar> Default for ArmstrongState<S> {
    fn default() -> Self {
        let zero = S::zero();
        Self { spring: zero, sliding: false, dwelt: zero, risen: zero, left: zero, lagged: zero }
    }
}

impl<S: Scalar> Armstrong<S> {
    /// Stribeck friction F_S(γ, t₂) after the dwell time `dwelt`, in s, starting from `left`, N.
    ///
    /// ```
    /// # let law = friction::Armstrong {
    /// #     coulomb: 2.0, viscous: 0.0, stribeck: 1.0, stiffness: 1e5, stribeck_velocity: 0.01, memory: 0.0, dwell: 0.1,
    /// # };
    /// assert_eq!(law.risen(0.4, 0.1), 0.7); // halfway to F_S∞ after γ
    /// ```
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
            // finite: ∞/(∞ + γ) would be NaN
            state.dwelt = (state.dwelt + motion.dt).min(S::lit(1e30));
            let risen = self.risen(state.left, state.dwelt);
            let level = self.coulomb + risen;
            state.spring += self.stiffness * dx;
            if state.spring.abs() <= level {
                // viscous friction damps the spring, so that a stuck body comes to rest
                return limits::bounded(state.spring + self.viscous * v);
            }
            state.sliding = true;
            state.risen = risen;
        }
        let level = self.coulomb + state.risen * fallen;
        state.spring = level * state.spring.sgn();
        limits::bounded(state.spring + self.viscous * v)
    }

    fn stored(&self, state: &Self::State) -> S {
        S::lit(0.5) * state.spring * state.spring / self.stiffness
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
