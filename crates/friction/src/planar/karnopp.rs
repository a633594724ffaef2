//! Karnopp friction in the plane.

use super::law::without_direction;
use super::{FrictionLaw, Grain, Motion, Vector};
use crate::{FrictionLaw as _, Invalid, Scalar, limits};
use serde::{Deserialize, Serialize};

/// Karnopp friction [karnopp-1985] in the plane, see [`crate::Karnopp`]: within a disc of velocities the contact stops
/// the body, up to break-away; outside of it the friction is that of sliding.
///
/// ```
/// use friction::planar::{FrictionLaw, Grain, Karnopp, Motion, Vector};
/// let law = Karnopp { c: 3.0, b: 2.0, d: 3.5, delta_v: 0.02, grain: Grain::default() };
/// let sliding = Motion { velocity: Vector { x: 0.0, y: 0.1 }, ..Motion::default() };
/// assert!((law.step(&mut (), &sliding).y - 3.2_f64).abs() < 1e-12);
/// let pulled_loose = Motion { applied: Vector { x: -9.0, y: 0.0 }, ..Motion::default() };
/// assert_eq!(law.step(&mut (), &pulled_loose), Vector { x: -3.5, y: 0.0 }); // break-away
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Karnopp<S> {
    /// Dynamic friction along the grain, N.
    pub c: S,
    /// Viscous friction along the grain, N·s/m.
    pub b: S,
    /// Static friction along the grain, N.
    pub d: S,
    /// Speed up to which the body counts as at rest, Δv, m/s.
    pub delta_v: S,
    /// The grain. The default is none.
    pub grain: Grain<S>,
}

impl<S: Scalar> Karnopp<S> {
    /// The law on a line along the grain.
    ///
    /// ```
    /// use friction::planar::{Grain, Karnopp};
    /// let law = Karnopp { c: 3.0, b: 2.0, d: 3.5, delta_v: 0.02, grain: Grain::default() };
    /// assert_eq!((law.line().c_n, law.line().d_p), (3.0, 3.5));
    /// ```
    pub fn line(&self) -> crate::Karnopp<S> {
        let Self { c, b, d, delta_v, .. } = *self;
        crate::Karnopp { c_p: c, c_n: c, b_p: b, b_n: b, d_p: d, d_n: d, delta_v }
    }
}

impl<S: Scalar> FrictionLaw<S> for Karnopp<S> {
    type State = ();

    fn step(&self, (): &mut (), motion: &Motion<S>) -> Vector<S> {
        if !motion.is_finite() {
            return Vector::nan();
        }
        let grain = &self.grain;
        if !self.line().is_stuck(motion.velocity.norm()) {
            let level = limits::sliding(self.c, self.b, grain.slip(motion.velocity).norm());
            return grain.sliding(motion.velocity, level);
        }
        let stop = motion.stopping_force().bounded();
        if grain.level_of(stop) > self.d { grain.nearest(stop, self.d) } else { stop }
    }

    fn validate(&self) -> Result<(), Invalid> {
        self.line().validate().map_err(without_direction)?;
        self.grain.validate()
    }
}
