//! The classic model: Coulomb with stiction, its jump at rest replaced by a steep line.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// The "classic" stick-slip model of section 2.4.2 (Haessig and Friedland 1991).
///
/// ```text
/// |v| ≤ v₀        F = F_s v/v₀
/// v₀ < |v| < v₁   F = s (F_s + (F_d − F_s)(|v| − v₀)/(v₁ − v₀))
/// |v| ≥ v₁        F = s (F_d + b (|v| − v₁)),   s = sgn v
/// ```
///
/// It shows stiction and the fall to sliding friction without a memory. It cannot hold: under a load below F_s a body
/// creeps at v₀ F/F_s, and the slope F_s/v₀ is a damper that a time step longer than 2 m v₀/F_s does not take.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Classic<S> {
    /// Static friction F_s, reached at v₀, N; at least `dynamic`.
    pub stiction: S,
    /// Sliding friction F_d, reached at v₁, N.
    pub dynamic: S,
    /// Viscous friction beyond v₁, b, N·s/m.
    pub viscous: S,
    /// Speed v₀ up to which the line rises, m/s.
    pub knee: S,
    /// Speed v₁ at which sliding friction is reached, m/s; at least `knee`.
    pub fallen: S,
}

impl<S: Scalar> FrictionLaw<S> for Classic<S> {
    type State = ();

    fn step(&self, (): &mut (), motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let speed = motion.velocity.abs();
        let level = if speed <= self.knee {
            self.stiction * (speed / self.knee)
        } else if speed < self.fallen {
            let fallen = (speed - self.knee) / (self.fallen - self.knee);
            self.stiction + (self.dynamic - self.stiction) * fallen
        } else {
            limits::sliding(self.dynamic, self.viscous, speed - self.fallen)
        };
        limits::bounded(level * motion.velocity.sgn())
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("dynamic", self.dynamic, 0.0, limits::LEVEL)?;
        in_range("stiction", self.stiction, self.dynamic.re(), limits::LEVEL)?;
        in_range("viscous", self.viscous, 0.0, limits::VISCOUS)?;
        in_range("knee", self.knee, 1e-6, 1e3)?;
        in_range("fallen", self.fallen, self.knee.re(), 1e3)
    }
}
