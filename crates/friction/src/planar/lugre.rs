//! LuGre friction in the plane.

use super::{FrictionLaw, Grain, Motion, Vector};
use crate::{FrictionLaw as _, Invalid, Scalar, limits};
use serde::{Deserialize, Serialize};

/// LuGre friction [canudas-de-wit-1995] in the plane, see [`crate::LuGre`].
///
/// ```text
/// dz/dt = v − σ₀ |v| z / g(|v|),   F = σ₀ z + σ₁ dz/dt + σ₂ v
/// ```
///
/// z has the same closed solution as on a line, and stays in the disc |z| ≤ F_s/σ₀.
///
/// ```
/// use friction::planar::{FrictionLaw, Grain, LuGre, LuGreState, Motion, Vector};
/// let contact = friction::LuGre {
///     sigma_0: 1e5, sigma_1: 0.0, sigma_2: 0.4, coulomb: 1.0, stiction: 1.5, stribeck_velocity: 1e-3,
/// };
/// let law = LuGre { contact, grain: Grain::default() };
/// let far = Vector { x: -0.1, y: 0.0 };
/// let motion = Motion { dt: 1.0, displacement: far, velocity: far, ..Motion::default() };
/// let force = law.step(&mut LuGreState::default(), &motion);
/// assert!((force.x + 1.04_f64).abs() < 1e-12 && force.y == 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LuGre<S> {
    /// The contact along the grain.
    pub contact: crate::LuGre<S>,
    /// The grain. The default is none.
    pub grain: Grain<S>,
}

/// State of [`LuGre`].
///
/// ```
/// let fresh = friction::planar::LuGreState::<f32>::default();
/// assert_eq!(fresh.z.norm(), 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LuGreState<S> {
    /// Mean deflection of the bristles along and across the grain, in the coordinates of [`Grain::slip`], m.
    pub z: Vector<S>,
}

impl<S: Scalar> Default for LuGreState<S> {
    fn default() -> Self {
        Self { z: Vector::default() }
    }
}

impl<S: Scalar> FrictionLaw<S> for LuGre<S> {
    type State = LuGreState<S>;

    fn step(&self, state: &mut LuGreState<S>, motion: &Motion<S>) -> Vector<S> {
        if !motion.is_finite() {
            return Vector::nan();
        }
        let law = &self.contact;
        let slip = self.grain.slip(motion.velocity);
        let (distance, direction) = self.grain.slip(motion.displacement).polar();
        let (compliance, inverse_v_s) = law.inverses();
        let before = state.z.within(law.stiction * compliance);
        state.z = if distance > S::zero() {
            let level = limits::stribeck_at(law.coulomb, law.stiction, slip.norm() * inverse_v_s);
            let end = direction * (level * compliance);
            end + (before - end) * law.left(-distance, level)
        } else {
            before
        };
        self.grain.force(bristles(law, before, state.z, motion.dt, slip))
    }

    fn validate(&self) -> Result<(), Invalid> {
        self.contact.validate()?;
        self.grain.validate()
    }
}

/// σ₀ z + σ₁ dz/dt + σ₂ w.
pub(super) fn bristles<S: Scalar>(
    law: &crate::LuGre<S>,
    before: Vector<S>,
    z: Vector<S>,
    dt: S,
    slip: Vector<S>,
) -> Vector<S> {
    let rate = if dt > S::zero() {
        let change = z - before;
        Vector { x: change.x / dt, y: change.y / dt }.bounded()
    } else {
        Vector::default()
    };
    z * law.sigma_0 + rate * law.sigma_1 + slip * law.sigma_2
}
