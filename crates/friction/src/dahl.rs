//! Dahl friction with separate limits for each direction.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

described! {
    /// Modified Dahl friction [dahl-1968] [thesis, eq. 3.2 and 3.3]. Limits are magnitudes.
    ///
    /// ```text
    /// dz/dx = σ |1 − s z/D|^i sgn(1 − s z/D),  s = sgn(dx),  D = D_p or D_n by s
    /// F = z + b v
    /// ```
    ///
    /// Integrated with Euler's method the model is unstable for large σ [thesis, ch. 3.5]. Written for the gap g = D − s z
    /// the equation is dg/|dx| = −σ (g/D)^i, which has a closed solution for every i. This law uses that solution: any σ and
    /// any displacement are stable, z stays within [−D_n, D_p], and the force does not depend on how a displacement is
    /// divided into steps.
    ///
    /// Every Dahl model drifts under a vibrating load: each half cycle returns less displacement than it took.
    ///
    /// ```
    /// use friction::{Dahl, DahlState, FrictionLaw, Motion};
    /// // aluminium on Teflon, [thesis, table 3-4]
    /// let teflon = Dahl { limit_p: 0.6389, limit_n: 0.5774, sigma: 10_000.0, exponent: 1.0, viscous: 0.3838 };
    /// let mut state = DahlState::default();
    /// let presliding = Motion { displacement: 0.6389e-4, ..Motion::default() }; // D/σ
    /// let force: f64 = teflon.step(&mut state, &presliding);
    /// assert!((force - 0.6389 * (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct Dahl<S> {
        /// Friction limit in positive motion, D_p, N.
        pub limit_p: S,
        /// Friction limit in negative motion, D_n, N.
        pub limit_n: S,
        /// Stiffness at z = 0, σ, N/m.
        pub sigma: S,
        /// Shape exponent i, dimensionless: 1 is an exponential approach to the limit, 0 an ideal spring with a slider.
        pub exponent: S,
        /// Viscous friction b, N·s/m.
        pub viscous: S,
    }
}

/// State of [`Dahl`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DahlState<S> {
    /// Friction force without the viscous part, z, N.
    pub z: S,
}

impl<S: Scalar> Default for DahlState<S> {
    fn default() -> Self {
        Self { z: S::zero() }
    }
}

impl<S: Scalar> Dahl<S> {
    /// Fraction of the gap D − s z that remains after sliding `distance`.
    pub(crate) fn decay(&self, gap: S, limit: S, distance: S) -> S {
        // Infinity, and 0·∞ from a vanishing limit, are capped: both slide to the limit.
        let cap = S::lit(1e30);
        let slid = cap.min(self.sigma * distance / limit);
        let one = S::one();
        if self.exponent == one && !self.exponent.has_derivative() {
            return (-slid).exp();
        }
        self.curved(slid, gap, limit)
    }

    /// The same for an exponent other than 1, which no device renders.
    #[cold]
    #[inline(never)]
    fn curved(&self, slid: S, gap: S, limit: S) -> S {
        let (cap, one) = (S::lit(1e30), S::one());
        let over = self.exponent - one;
        let slid = cap.min(slid * (gap / limit).powf(over));
        // (1 + y)^(−1/over) with y = over·slid, smooth through over = 0
        let y = over * slid;
        if y <= -one {
            return S::zero(); // i < 1 reaches the limit in a finite distance
        }
        let rate = if y.abs() < S::lit(1e-3) {
            one - y * (S::lit(0.5) - y * (S::lit(1.0 / 3.0) - y * (S::lit(0.25) - y * S::lit(0.2))))
        } else {
            (one + y).ln() / y
        };
        (-slid * rate).exp()
    }
}

impl<S: Scalar> FrictionLaw<S> for Dahl<S> {
    type State = DahlState<S>;

    fn step(&self, state: &mut DahlState<S>, motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let (dx, zero) = (motion.displacement, S::zero());
        let z = state.z.clamp(-self.limit_n, self.limit_p);
        state.z = if dx == zero {
            z
        } else {
            let (sign, limit) = if dx > zero { (S::one(), self.limit_p) } else { (-S::one(), self.limit_n) };
            let gap = limit - sign * z;
            let left =
                if gap > zero && limit > zero { gap * self.decay(gap, limit, sign * dx) } else { zero };
            (sign * (limit - left)).clamp(-self.limit_n, self.limit_p)
        };
        limits::bounded(state.z + self.viscous * motion.velocity)
    }

    fn stored(&self, state: &Self::State) -> S {
        S::lit(0.5) * state.z * state.z / self.sigma
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("limit_p", self.limit_p, 0.0, limits::LEVEL)?;
        in_range("limit_n", self.limit_n, 0.0, limits::LEVEL)?;
        in_range("sigma", self.sigma, f64::from(f32::MIN_POSITIVE), limits::STIFFNESS)?;
        in_range("exponent", self.exponent, 0.0, 10.0)?;
        in_range("viscous", self.viscous, -limits::VISCOUS, limits::VISCOUS)
    }
}
