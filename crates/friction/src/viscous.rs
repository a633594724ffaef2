//! Viscous friction of a fluid film.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

described! {
    /// Viscous friction F = b v with a separate b for each direction [thesis, eq. 2.3]. Holds nothing at rest.
    ///
    /// ```
    /// use friction::{FrictionLaw, Motion, Viscous};
    /// // the fifth resistance of [thesis, table 5-2]
    /// let law = Viscous { damping_p: 35.0, damping_n: 35.0 };
    /// let moving = Motion { velocity: -0.1, ..Motion::default() };
    /// assert!((law.step(&mut (), &moving) + 3.5_f64).abs() < 1e-12);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct Viscous<S> {
        /// Coefficient b in positive motion, N·s/m.
        pub damping_p: S,
        /// Coefficient b in negative motion, N·s/m.
        pub damping_n: S,
    }
}

impl<S: Scalar> FrictionLaw<S> for Viscous<S> {
    type State = ();

    fn step(&self, (): &mut (), motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let v = motion.velocity;
        limits::bounded(if v > S::zero() { self.damping_p * v } else { self.damping_n * v })
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("damping_p", self.damping_p, 0.0, limits::VISCOUS)?;
        in_range("damping_n", self.damping_n, 0.0, limits::VISCOUS)
    }
}
