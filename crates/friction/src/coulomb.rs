//! Coulomb friction as a stopping force: sticks exactly, without a velocity dead band.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

described! {
    /// Coulomb and viscous friction with break-away: the force that would stop the body within this step, clipped to the
    /// friction level. F = clamp(m v / dt + F_a, −limit_n, limit_p).
    ///
    /// The clipped force is the implicit solution F ∈ level·Sgn(v at the end of the step). A body comes to rest in finite
    /// time and stays there: no dead band, no creep, no zero-crossing limit cycle at any step length. The limit is `static_*`
    /// for a body at rest or about to reverse, `level_* + viscous_* |v|` for a sliding one.
    ///
    /// With `mass = 0` the law cannot stop anything: F = (level + viscous |v|) sgn v while v ≠ 0, and at v = 0 it balances
    /// F_a up to `static_*`.
    ///
    /// ```
    /// use friction::{Coulomb, CoulombState, FrictionLaw, Motion};
    /// let law = Coulomb { level_p: 3.0, level_n: 3.0, static_p: 3.5, static_n: 3.5, viscous_p: 0.0, viscous_n: 0.0 };
    /// let mut state = CoulombState { sliding: true };
    /// // 0.5 kg at 1 mm/s: half a newton brings it to rest within 1 ms
    /// let slow = Motion { dt: 1e-3, velocity: 1e-3, mass: 0.5, ..Motion::default() };
    /// assert!((law.step(&mut state, &slow) - 0.5_f64).abs() < 1e-12);
    /// assert!(!state.sliding);
    /// // from rest the load must exceed the static friction
    /// let held = Motion { dt: 1e-3, applied: 3.4, mass: 0.5, ..Motion::default() };
    /// assert_eq!(law.step(&mut state, &held), 3.4);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct Coulomb<S> {
        /// Dynamic friction in positive motion, N.
        pub level_p: S,
        /// Dynamic friction in negative motion, magnitude, N.
        pub level_n: S,
        /// Static friction against positive motion, N; at least `level_p`.
        pub static_p: S,
        /// Static friction against negative motion, magnitude, N; at least `level_n`.
        pub static_n: S,
        /// Viscous friction in positive motion, N·s/m.
        pub viscous_p: S,
        /// Viscous friction in negative motion, N·s/m.
        pub viscous_n: S,
    }
}

/// State of [`Coulomb`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CoulombState {
    /// The contact broke away and has not come to rest since. The velocity cannot tell: after a stop it is zero only
    /// up to rounding.
    pub sliding: bool,
}

impl<S: Scalar> FrictionLaw<S> for Coulomb<S> {
    type State = CoulombState;

    fn step(&self, state: &mut CoulombState, motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let (v, zero) = (motion.velocity, S::zero());
        let slide_p = limits::sliding(self.level_p, self.viscous_p, v.max(zero));
        let slide_n = limits::sliding(self.level_n, self.viscous_n, (-v).max(zero));
        let massless = !(motion.mass > zero && motion.dt > zero);
        if massless && v != zero {
            state.sliding = true;
            return limits::bounded(if v > zero { slide_p } else { -slide_n });
        }
        // a sliding body meets static friction only across a reversal
        let hold_p = if state.sliding && v > zero { slide_p } else { slide_p.max(self.static_p) };
        let hold_n = if state.sliding && v < zero { slide_n } else { slide_n.max(self.static_n) };
        let stop = motion.stopping_force();
        state.sliding = true;
        limits::bounded(if stop > hold_p {
            slide_p
        } else if stop < -hold_n {
            -slide_n
        } else {
            state.sliding = false;
            stop
        })
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("level_p", self.level_p, 0.0, limits::LEVEL)?;
        in_range("level_n", self.level_n, 0.0, limits::LEVEL)?;
        in_range("static_p", self.static_p, self.level_p.re(), limits::LEVEL)?;
        in_range("static_n", self.static_n, self.level_n.re(), limits::LEVEL)?;
        in_range("viscous_p", self.viscous_p, -limits::VISCOUS, limits::VISCOUS)?;
        in_range("viscous_n", self.viscous_n, -limits::VISCOUS, limits::VISCOUS)
    }
}
