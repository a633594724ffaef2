//! Dahl's friction, modified for different limits in the two directions (thesis eq. 3.2, 3.3).

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// Modified Dahl friction, eq. 3.2 and 3.3. Limits are magnitudes.
///
/// ```text
/// dz/dx = σ |1 − s z/D|^i sgn(1 − s z/D),  s = sgn(dx),  D = D_p or D_n by s
/// F = z + b v
/// ```
///
/// The thesis notes that the model is unstable when σ is large. That is Euler's doing, not Dahl's: in the gap
/// g = D − s z the equation is dg/|dx| = −σ (g/D)^i, which has a closed solution for every i, and this law steps by it.
/// So any σ and any displacement are stable, z never leaves [−D_n, D_p], and the force does not depend
/// on how a displacement was cut into steps.
///
/// Under a load that vibrates, every Dahl model drifts (each half cycle gives back less than it took).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dahl<S> {
    /// Friction limit in positive motion, D_p, N.
    pub limit_p: S,
    /// Friction limit in negative motion, D_n, N.
    pub limit_n: S,
    /// Stiffness at z = 0, σ, N/m.
    pub sigma: S,
    /// Shape i, dimensionless: 1 decays exponentially, 0 is an ideal spring and slider.
    pub exponent: S,
    /// Viscous friction b, N·s/m.
    pub viscous: S,
}

/// What [`Dahl`] remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DahlState<S> {
    /// Friction without its viscous part, z, N.
    pub z: S,
}

impl<S: Scalar> Default for DahlState<S> {
    fn default() -> Self {
        Self { z: S::zero() }
    }
}

impl<S: Scalar> Dahl<S> {
    /// What is left of the gap D − s z after sliding `distance`, as a share of what it was.
    fn decay(&self, gap: S, limit: S, distance: S) -> S {
        // A cap in place of infinity (and of 0·∞, which only a vanishing limit gives): both slide to the limit.
        let cap = S::lit(1e30);
        let slid = cap.min(self.sigma * distance / limit);
        let one = S::one();
        if self.exponent == one && !self.exponent.has_derivative() {
            return (-slid).exp();
        }
        let over = self.exponent - one;
        let slid = cap.min(slid * (gap / limit).powf(over));
        // (1 + y)^(−1/over) with y = over·slid, written so that it passes smoothly through over = 0.
        let y = over * slid;
        if y <= -one {
            return S::zero(); // i < 1 reaches its limit in a finite distance
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

    fn validate(&self) -> Result<(), Invalid> {
        in_range("limit_p", self.limit_p, 0.0, limits::LEVEL)?;
        in_range("limit_n", self.limit_n, 0.0, limits::LEVEL)?;
        in_range("sigma", self.sigma, f64::from(f32::MIN_POSITIVE), limits::STIFFNESS)?;
        in_range("exponent", self.exponent, 0.0, 10.0)?;
        in_range("viscous", self.viscous, -limits::VISCOUS, limits::VISCOUS)
    }
}
