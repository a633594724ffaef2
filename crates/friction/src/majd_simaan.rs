//! Majd and Simaan's friction: stiction, Stribeck and viscous friction in one continuous curve.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

described! {
    /// Friction of Majd and Simaan [majd-1995] [thesis, eq. 2.9].
    ///
    /// ```text
    /// F(v) = f_v v + [f_c + σ e^(−|v|/v_c) − (σ + f_c) e^(−n|v|/v_c)] sgn v
    /// ```
    ///
    /// The curve is continuous through zero and has no state. For the same reason the law cannot hold: under a load a body
    /// creeps. Its slope at rest, f_v + ((n − 1)σ + n f_c)/v_c ([`MajdSimaan::slope_at_rest`]), acts as a damper and limits
    /// the time step.
    ///
    /// ```
    /// use friction::{FrictionLaw, MajdSimaan, Motion};
    /// let law = MajdSimaan { viscous: 2.0, coulomb: 3.0, stribeck: 0.0, critical_velocity: 1e-3, steepness: 10.0 };
    /// let force = |velocity| law.step(&mut (), &Motion { velocity, ..Motion::default() });
    /// assert_eq!(force(0.0), 0.0_f64);
    /// assert!((force(0.1) - 3.2).abs() < 1e-12); // f_c + f_v v
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct MajdSimaan<S> {
        /// Slope well beyond the Stribeck region, f_v, N·s/m.
        pub viscous: S,
        /// Coulomb friction f_c, N.
        pub coulomb: S,
        /// Amplitude of the Stribeck part σ, N. [`MajdSimaan::with_stiction`] computes it from the static friction.
        pub stribeck: S,
        /// Critical velocity v_c, m/s.
        pub critical_velocity: S,
        /// Steepness at rest n, dimensionless. Above 1.
        pub steepness: S,
    }
}

impl<S: Scalar> MajdSimaan<S> {
    /// Curve without the viscous part at speed `u`·v_c, N.
    fn level(&self, u: S) -> S {
        let u = u.min(S::lit(1e3));
        self.coulomb + self.stribeck * (-u).exp()
            - (self.stribeck + self.coulomb) * (-(self.steepness * u).min(S::lit(1e3))).exp()
    }

    /// Slope dF/dv at rest, N·s/m.
    ///
    /// ```
    /// # let law = friction::MajdSimaan {
    /// #     viscous: 2.0, coulomb: 3.0, stribeck: 0.0, critical_velocity: 1e-3, steepness: 10.0,
    /// # };
    /// assert!((law.slope_at_rest() - 30_002.0_f64).abs() < 1e-9);
    /// ```
    pub fn slope_at_rest(&self) -> S {
        let n = self.steepness;
        self.viscous + ((n - S::one()) * self.stribeck + n * self.coulomb) / self.critical_velocity
    }
}

impl<S: Scalar> MajdSimaan<S> {
    /// Peak of the curve without the viscous part, N.
    ///
    /// It lies at u = ln(n(1 + f_c/σ))/(n − 1), in v_c.
    ///
    /// ```
    /// let law = friction::MajdSimaan { viscous: 0.0, coulomb: 3.0, stribeck: 0.0, critical_velocity: 1e-3, steepness: 10.0 };
    /// assert_eq!(law.stiction(), 3.0_f64); // without a Stribeck part the curve rises to f_c
    /// ```
    pub fn stiction(&self) -> S {
        let (n, one) = (self.steepness, S::one());
        if self.stribeck > S::zero() {
            self.level((n * (one + self.coulomb / self.stribeck)).ln() / (n - one))
        } else {
            self.coulomb
        }
    }

    /// The law whose curve without the viscous part peaks at `stiction`, N. The peak grows with σ, which is found by
    /// bisection.
    ///
    /// ```
    /// use friction::{FrictionLaw, MajdSimaan, Motion};
    /// let law = MajdSimaan { viscous: 0.0, coulomb: 3.0, stribeck: 0.0, critical_velocity: 1e-3, steepness: 10.0 };
    /// let law = law.with_stiction(3.5);
    /// let force = |k| law.step(&mut (), &Motion { velocity: 1e-6 * f64::from(k), ..Motion::default() });
    /// let peak = (0..5_000).map(force).fold(0.0, f64::max);
    /// assert!((peak - 3.5).abs() < 1e-6);
    /// ```
    #[must_use]
    pub fn with_stiction(mut self, stiction: S) -> Self {
        let (mut low, mut high) = (S::zero(), S::one());
        let peak = |sigma: S| Self { stribeck: sigma, ..self }.stiction();
        let most = S::lit(limits::LEVEL);
        while peak(high) < stiction && high < most {
            high = (high + high).min(most);
        }
        for _ in 0..200 {
            let middle = S::lit(0.5) * (low + high);
            if middle == low || middle == high {
                break;
            }
            if peak(middle) < stiction { low = middle } else { high = middle }
        }
        self.stribeck = S::lit(0.5) * (low + high);
        self
    }
}

impl<S: Scalar> FrictionLaw<S> for MajdSimaan<S> {
    type State = ();

    fn step(&self, (): &mut (), motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let v = motion.velocity;
        let level = self.level(v.abs() / self.critical_velocity);
        limits::bounded(self.viscous * v + level * v.sgn())
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("viscous", self.viscous, 0.0, limits::VISCOUS)?;
        in_range("coulomb", self.coulomb, 0.0, limits::LEVEL)?;
        in_range("stribeck", self.stribeck, 0.0, limits::LEVEL)?;
        in_range("critical_velocity", self.critical_velocity, 1e-6, 1e3)?;
        in_range("steepness", self.steepness, 1.000_001, 1e6)
    }
}
