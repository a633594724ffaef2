//! Majd and Simaan's friction: stiction, Stribeck and viscous friction in one continuous curve.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// Friction of Majd and Simaan (1995), eq. 2.9.
///
/// ```text
/// F(v) = f_v v + [f_c + σ e^(−|v|/v_c) − (σ + f_c) e^(−n|v|/v_c)] sgn v
/// ```
///
/// Continuous through zero: no dead band and no memory. For the same reason it cannot hold: under a load a body creeps
/// with the slope f_v + ((n − 1)σ + n f_c)/v_c at rest, [`MajdSimaan::slope_at_rest`], and that slope is a damper which
/// the time step has to take.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MajdSimaan<S> {
    /// Slope well beyond the Stribeck region, f_v, N·s/m.
    pub viscous: S,
    /// Coulomb friction f_c, N.
    pub coulomb: S,
    /// Size of the Stribeck part σ, N. [`MajdSimaan::with_stiction`] finds it from the static friction.
    pub stribeck: S,
    /// Critical velocity v_c, m/s.
    pub critical_velocity: S,
    /// Steepness at rest n, dimensionless, above 1.
    pub steepness: S,
}

impl<S: Scalar> MajdSimaan<S> {
    /// The curve without its viscous part at speed `u`·v_c, N.
    fn level(&self, u: S) -> S {
        let u = u.min(S::lit(1e3));
        self.coulomb + self.stribeck * (-u).exp()
            - (self.stribeck + self.coulomb) * (-(self.steepness * u).min(S::lit(1e3))).exp()
    }

    /// dF/dv at rest, N·s/m.
    pub fn slope_at_rest(&self) -> S {
        let n = self.steepness;
        self.viscous + ((n - S::one()) * self.stribeck + n * self.coulomb) / self.critical_velocity
    }
}

impl MajdSimaan<f64> {
    /// The law whose curve without its viscous part has `stiction` as its largest value, N: σ by bisection, since the
    /// largest value grows with σ. The largest value lies at u = ln(n(1 + f_c/σ))/(n − 1).
    #[must_use]
    pub fn with_stiction(mut self, stiction: f64) -> Self {
        let (mut low, mut high) = (0.0, 1.0);
        let peak = |sigma: f64| {
            let law = Self { stribeck: sigma, ..self };
            let n = law.steepness;
            law.level(libm::log(n * (1.0 + law.coulomb / sigma)) / (n - 1.0))
        };
        while peak(high) < stiction && high < limits::LEVEL {
            high *= 2.0;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if peak(middle) < stiction { low = middle } else { high = middle }
        }
        self.stribeck = 0.5 * (low + high);
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
