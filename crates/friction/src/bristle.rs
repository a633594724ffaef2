//! Haessig and Friedland's bristles: bonds that stretch, snap and form anew at random.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// Draws before a bond that was carried far beyond its snapping point is placed by its steady distribution.
const DRAWS: usize = 4;

/// The bristle model (Haessig and Friedland 1991), eq. 2.5 and 2.6, with `N` bonds; each is 1/N of the contact.
///
/// ```text
/// F = Σ (σ/N)(x_i − b_i);   |x_i − b_i| > Δ:  b_i ← b_i + uniform(Δ) sgn(x_i − b_i)
/// ```
///
/// Bonds renew after distances uniform in [0, Δ], so in steady sliding the deflection left to the snapping point has
/// the density 2(1 − r/Δ)/Δ and its mean is Δ/3: the friction is σ·2Δ/3, and fluctuates by σΔ/√(18 N) while a fresh
/// contact breaks away at σΔ. `level` is the steady friction, so Δ = 1.5 level/σ.
///
/// The force is rough: that is the model. It costs one addition and one comparison a bond and step, fifty are enough
/// (section 2.4.4).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bristle<S, const N: usize = 50> {
    /// Stiffness of all bonds together σ, N/m.
    pub stiffness: S,
    /// Mean friction in steady sliding, N.
    pub level: S,
    /// Viscous friction, N·s/m.
    pub viscous: S,
}

/// What [`Bristle`] remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BristleState<S, const N: usize = 50> {
    /// Deflection of each bond, in snapping points: −1 … 1.
    pub deflection: [S; N],
    /// State of the xorshift generator (Marsaglia 2003), never 0.
    pub random: u32,
}

impl<S: Scalar, const N: usize> Default for BristleState<S, N> {
    fn default() -> Self {
        Self { deflection: [S::zero(); N], random: 0x9e37_79b9 }
    }
}

impl<S: Scalar, const N: usize> BristleState<S, N> {
    /// Uniform in [0, 1).
    fn uniform(&mut self) -> S {
        let mut x = self.random;
        x ^= x << 13;
        x ^= x >> 17;
        x ^= x << 5;
        self.random = x;
        S::fraction(x)
    }
}

impl<S: Scalar, const N: usize> Bristle<S, N> {
    /// Snapping point Δ, m.
    pub fn snapping_point(&self) -> S {
        S::lit(1.5) * self.level / self.stiffness
    }
}

impl<S: Scalar, const N: usize> FrictionLaw<S> for Bristle<S, N> {
    type State = BristleState<S, N>;

    fn step(&self, state: &mut BristleState<S, N>, motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let (zero, one) = (S::zero(), S::one());
        let viscous = self.viscous * motion.velocity;
        let snapping = self.snapping_point();
        if !(snapping > zero) {
            return limits::bounded(viscous);
        }
        let stretch = (motion.displacement / snapping).clamp(S::lit(-1e6), S::lit(1e6));
        let mut sum = zero;
        for bond in 0..N {
            let Some(&before) = state.deflection.get(bond) else { break };
            let mut deflection = before + stretch;
            let mut draws = 0;
            while deflection.abs() > one {
                let towards = deflection.sgn();
                let uniform = state.uniform();
                deflection = if draws < DRAWS {
                    deflection - towards * uniform
                } else {
                    // 1 − r with P(r < R) = 1 − (1 − R)²
                    towards * uniform.sqrt()
                };
                draws += 1;
            }
            if let Some(own) = state.deflection.get_mut(bond) {
                *own = deflection;
            }
            sum += deflection;
        }
        limits::bounded(S::lit(1.5 / N as f64) * self.level * sum + viscous)
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("stiffness", self.stiffness, 1e-3, limits::STIFFNESS)?;
        in_range("level", self.level, 0.0, limits::LEVEL)?;
        in_range("viscous", self.viscous, 0.0, limits::VISCOUS)
    }
}
