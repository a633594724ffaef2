//! Effects of the catalogue in the plane.

use super::{Dahl, DahlState, FrictionLaw, Grain, Motion, Vector};
use crate::Scalar;
use crate::effects::{EffectKind, Quantity};

/// What an effect on a line is in the plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InPlane {
    /// Against the motion, as large as at the same speed on a line.
    AlongPath,
    /// A field of force: each axis has its own, over its position.
    AlongAxes,
    /// Bristles that bend in any direction.
    Bristles,
}

impl InPlane {
    /// What this effect is in the plane; None where that is more than one thing, or nothing.
    ///
    /// ```
    /// use friction::effects::EffectKind;
    /// use friction::planar::InPlane;
    /// assert_eq!(InPlane::of(EffectKind::Stribeck), Some(InPlane::AlongPath));
    /// assert_eq!(InPlane::of(EffectKind::Spring), Some(InPlane::AlongAxes));
    /// assert_eq!(InPlane::of(EffectKind::Presliding), Some(InPlane::Bristles));
    /// assert_eq!(InPlane::of(EffectKind::TorqueRipple), None);
    /// ```
    #[must_use]
    pub fn of(kind: EffectKind) -> Option<Self> {
        let about = kind.about();
        let reads_only = |known: &[Quantity]| about.reads.iter().all(|q| known.contains(q));
        if kind == EffectKind::Presliding {
            Some(Self::Bristles)
        } else if about.is_constant() || about.only.is_some() {
            None
        } else if about.opposes_motion && reads_only(&[Quantity::Velocity, Quantity::Time]) {
            Some(Self::AlongPath)
        } else if !about.opposes_motion && reads_only(&[Quantity::Position]) {
            Some(Self::AlongAxes)
        } else {
            None
        }
    }
}

/// Force of bristles per unit of their level beyond that of a contact without: z − n, dz/ds = (n − z)/x_s, n the direction of
/// motion.
///
/// ```
/// use friction::planar::{DahlState, Motion, Vector, bent};
/// let (mut state, x) = (DahlState::default(), Vector { x: 1e-4, y: 0.0 });
/// let force: Vector<f64> = bent(1e-4, &mut state, &Motion { velocity: x, displacement: x, ..Motion::default() });
/// assert!((force.x + (-1f64).exp()).abs() < 1e-12); // e⁻¹ is still missing
/// ```
pub fn bent<S: Scalar>(x_s: S, state: &mut DahlState<S>, motion: &Motion<S>) -> Vector<S> {
    let (one, zero) = (S::one(), S::zero());
    let law = Dahl { limit: one, sigma: one / x_s, exponent: one, viscous: zero, grain: Grain::default() };
    law.step(state, motion) - motion.velocity.polar().1
}
