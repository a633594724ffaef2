//! Coulomb friction in the plane as a stopping force: sticks exactly in every direction.

use super::{FrictionLaw, Grain, Motion, Vector};
use crate::coulomb::CoulombState;
use crate::{Invalid, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// Coulomb and viscous friction with break-away in the plane [kikuuwe-2006], see [`crate::Coulomb`]: the force that would
/// stop the body within this step where the contact holds it, and the nearest one that it holds otherwise.
///
/// "Nearest" is measured by the inertia, see [`Grain::nearest`]: the velocity at the end of the step is zero, or normal to
/// the ellipse of forces. So friction never adds to the energy of a step, and at any step length the body comes to rest
/// in finite time.
///
/// ```
/// use friction::planar::{Coulomb, CoulombState, FrictionLaw, Grain, Motion, Vector};
/// let law = Coulomb { level: 3.0, stiction: 3.5, viscous: 0.0, grain: Grain::default() };
/// let mut state = CoulombState::default();
/// // at rest, pushed by 3.4 N in any direction: the load is balanced
/// let applied = Vector { x: 1.6, y: 3.0 };
/// assert_eq!(law.step(&mut state, &Motion { applied, mass: 0.5, dt: 1e-3, ..Motion::default() }), applied);
/// // 4 N along y break it away
/// let applied = Vector { x: 0.0, y: 4.0 };
/// let force = law.step(&mut state, &Motion { applied, mass: 0.5, dt: 1e-3, ..Motion::default() });
/// assert_eq!((force, state.sliding), (Vector { x: 0.0, y: 3.0 }, true));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coulomb<S> {
    /// Dynamic friction along the grain, N.
    pub level: S,
    /// Static friction along the grain, N; at least `level`.
    pub stiction: S,
    /// Viscous friction along the grain, N·s/m.
    pub viscous: S,
    /// The grain. The default is none.
    pub grain: Grain<S>,
}

impl<S: Scalar> Coulomb<S> {
    /// The law on a line along the grain.
    ///
    /// ```
    /// use friction::planar::{Coulomb, Grain};
    /// let law = Coulomb { level: 3.0, stiction: 3.5, viscous: 0.2, grain: Grain::default() };
    /// assert_eq!((law.line().level_n, law.line().static_p), (3.0, 3.5));
    /// ```
    pub fn line(&self) -> crate::Coulomb<S> {
        crate::Coulomb {
            level_p: self.level,
            level_n: self.level,
            static_p: self.stiction,
            static_n: self.stiction,
            viscous_p: self.viscous,
            viscous_n: self.viscous,
        }
    }
}

impl<S: Scalar> FrictionLaw<S> for Coulomb<S> {
    type State = CoulombState;

    fn step(&self, state: &mut CoulombState, motion: &Motion<S>) -> Vector<S> {
        if !motion.is_finite() {
            return Vector::nan();
        }
        let (zero, grain) = (S::zero(), &self.grain);
        let slip = grain.slip(motion.velocity);
        let massless = !(motion.mass > zero && motion.dt > zero);
        if massless && slip != Vector::default() {
            state.sliding = true;
            return grain.sliding(motion.velocity, limits::sliding(self.level, self.viscous, slip.norm()));
        }
        let stop = motion.stopping_force().bounded();
        // speed in the direction in which the body would go on without friction; against it the contact reverses
        let onward = slip.dot(grain.slip(stop).polar().1).max(zero);
        let slide = limits::sliding(self.level, self.viscous, onward);
        // a sliding body meets static friction only across a reversal
        let hold = if state.sliding && onward > zero { slide } else { slide.max(self.stiction) };
        state.sliding = grain.level_of(stop) > hold;
        if state.sliding { grain.nearest(stop, slide) } else { stop }
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("level", self.level, 0.0, limits::LEVEL)?;
        in_range("stiction", self.stiction, self.level.re(), limits::LEVEL)?;
        in_range("viscous", self.viscous, -limits::VISCOUS, limits::VISCOUS)?;
        self.grain.validate()
    }
}
