//! The classic stick-slip model: Coulomb friction with stiction and a steep line instead of a jump at rest.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

described! {
    /// The "classic" stick-slip model [haessig-1991] [thesis, ch. 2.4.2].
    ///
    /// ```text
    /// |v| ≤ v₀        F = F_s v/v₀
    /// v₀ < |v| < v₁   F = s (F_s + (F_d − F_s)(|v| − v₀)/(v₁ − v₀))
    /// |v| ≥ v₁        F = s (F_d + b (|v| − v₁)),   s = sgn v
    /// ```
    ///
    /// The model shows stiction and the fall to sliding friction without a state. It cannot hold: under a load F below F_s a
    /// body creeps at v₀ F/F_s. The slope F_s/v₀ is a damper; a time step longer than 2 m v₀/F_s is unstable.
    ///
    /// ```
    /// use friction::{Classic, FrictionLaw, Motion};
    /// let law = Classic { stiction: 3.5, dynamic: 3.0, viscous: 0.0, knee: 1e-3, fallen: 3e-3 };
    /// let force = |velocity| law.step(&mut (), &Motion { velocity, ..Motion::default() });
    /// assert!((force(1e-3) - 3.5_f64).abs() < 1e-12);
    /// assert!((force(2e-3) - 3.25).abs() < 1e-12); // halfway down
    /// assert!((force(-0.1) + 3.0).abs() < 1e-12);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct Classic<S> {
        /// Static friction F_s, reached at v₀, N. At least `dynamic`.
        pub stiction: S,
        /// Sliding friction F_d, reached at v₁, N.
        pub dynamic: S,
        /// Viscous friction beyond v₁, b, N·s/m.
        pub viscous: S,
        /// Speed v₀ at which static friction is reached, m/s.
        pub knee: S,
        /// Speed v₁ at which sliding friction is reached, m/s. At least `knee`.
        pub fallen: S,
    }
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
