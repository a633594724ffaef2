//! Haessig and Friedland's bristle model: bonds that stretch, snap and form again at random.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// Number of draws after which a bond far beyond its snapping point is drawn from the steady distribution.
const DRAWS: usize = 4;

described! {
    /// The bristle model [haessig-1991] [thesis, eq. 2.5 and 2.6] with `N` bonds. Each bond is 1/N of the contact.
    ///
    /// ```text
    /// F = Σ (σ/N)(x_i − b_i);   |x_i − b_i| > Δ:  b_i ← b_i + uniform(Δ) sgn(x_i − b_i)
    /// ```
    ///
    /// Bonds form again after distances uniform in [0, Δ]. In steady sliding the distance r to the snapping point therefore has
    /// the density 2(1 − r/Δ)/Δ and the mean Δ/3: the friction is σ·2Δ/3 and fluctuates by σΔ/√(18 N). A fresh contact breaks
    /// away at σΔ. `level` is the steady friction, so Δ = 1.5 level/σ.
    ///
    /// The force is rough by design of the model. A step costs one addition and one comparison for each bond; fifty bonds are
    /// enough [thesis, ch. 2.4.4].
    ///
    /// ```
    /// use friction::{Bristle, BristleState, FrictionLaw, Motion};
    /// let law: Bristle<f64, 50> = Bristle { stiffness: 1e5, level: 2.0, viscous: 0.0 };
    /// let mut state = BristleState::default();
    /// let step = Motion { displacement: 1e-5, ..Motion::default() };
    /// assert!((law.step(&mut state, &step) - 1.0).abs() < 1e-12); // a fresh contact is the spring σ
    /// let mean = (0..20_000).map(|_| law.step(&mut state, &step)).sum::<f64>() / 20_000.0;
    /// assert!((mean - 2.0).abs() < 0.02);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct Bristle<S, const N: usize = 50> {
        /// Stiffness of all bonds together σ, N/m.
        pub stiffness: S,
        /// Mean friction in steady sliding, N.
        pub level: S,
        /// Viscous friction, N·s/m.
        pub viscous: S,
    }
}

/// State of [`Bristle`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BristleState<S, const N: usize = 50> {
    /// Deflection of each bond in units of the snapping point, −1 to 1.
    pub deflection: [S; N],
    /// State of the xorshift generator [marsaglia-2003], never 0.
    pub random: u32,
}

impl<S: Scalar, const N: usize> Default for BristleState<S, N> {
    fn default() -> Self {
        Self { deflection: [S::zero(); N], random: 0x9e37_79b9 }
    }
}

impl<S: Scalar, const N: usize> BristleState<S, N> {
    /// Random number, uniform in [0, 1).
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
    ///
    /// ```
    /// let law: friction::Bristle<f64> = friction::Bristle { stiffness: 1e5, level: 2.0, viscous: 0.0 };
    /// assert!((law.snapping_point() - 3e-5).abs() < 1e-18);
    /// ```
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

    fn stored(&self, state: &Self::State) -> S {
        let squares = state.deflection.iter().fold(S::zero(), |sum, &bond| sum + bond * bond);
        // σ/2N Σ (Δ bond)², with σ Δ = 1.5 level
        S::lit(0.75 / N as f64) * self.level * self.snapping_point() * squares
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("stiffness", self.stiffness, 1e-3, limits::STIFFNESS)?;
        in_range("level", self.level, 0.0, limits::LEVEL)?;
        in_range("viscous", self.viscous, 0.0, limits::VISCOUS)
    }
}
