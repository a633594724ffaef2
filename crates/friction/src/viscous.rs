//! Viscous friction: the film between the surfaces.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// Viscous friction, eq. 2.3: F = b v, with its own b in each direction.
///
/// It holds nothing at rest. (The fifth resistance of table 5-2 is 35 N·s/m of it.)
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Viscous<S> {
    /// b in positive motion, N·s/m.
    pub damping_p: S,
    /// b in negative motion, N·s/m.
    pub damping_n: S,
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
