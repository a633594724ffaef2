//! Dahl friction in the plane.

use super::law::without_direction;
use super::{FrictionLaw, Grain, Motion, Vector};
use crate::{FrictionLaw as _, Invalid, Scalar};
use serde::{Deserialize, Serialize};

/// Dahl friction [dahl-1968] in the plane, see [`crate::Dahl`].
///
/// ```text
/// g = D n − z,  n the direction of motion;   dg/ds = −σ (g/D) (|g|/D)^(i−1);   F = z + b v
/// ```
///
/// The gap keeps its direction on a straight step and shrinks as on a line, so the closed solution is the same. z stays in
/// the disc |z| ≤ D, and dissipates for every i ≥ 0.
///
/// ```
/// use friction::planar::{Dahl, DahlState, FrictionLaw, Grain, Motion, Vector};
/// let law = Dahl { limit: 3.0, sigma: 50_000.0, exponent: 1.0, viscous: 0.0, grain: Grain::default() };
/// let mut state = DahlState::default();
/// let step = Motion { displacement: Vector { x: 3e-4, y: 4e-4 }, ..Motion::default() };
/// let force = law.step(&mut state, &step);
/// assert!((force.norm() - 3.0_f64 * (1.0 - (-25.0_f64 / 3.0).exp())).abs() < 1e-12);
/// assert!((force.y / force.x - 4.0 / 3.0).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Dahl<S> {
    /// Friction limit along the grain, D, N.
    pub limit: S,
    /// Stiffness along the grain at z = 0, σ, N/m.
    pub sigma: S,
    /// Shape exponent i, dimensionless.
    pub exponent: S,
    /// Viscous friction along the grain, b, N·s/m.
    pub viscous: S,
    /// The grain. The default is none.
    pub grain: Grain<S>,
}

/// State of [`Dahl`].
///
/// ```
/// let fresh = friction::planar::DahlState::<f32>::default();
/// assert_eq!(fresh.z.norm(), 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DahlState<S> {
    /// Friction force without the viscous part, along and across the grain, divided by the level in its direction: M⁻¹F, N.
    pub z: Vector<S>,
}

impl<S: Scalar> Default for DahlState<S> {
    fn default() -> Self {
        Self { z: Vector::default() }
    }
}

impl<S: Scalar> Dahl<S> {
    /// The law on a line along the grain.
    ///
    /// ```
    /// use friction::planar::{Dahl, Grain};
    /// let law = Dahl { limit: 3.0, sigma: 5e4, exponent: 1.0, viscous: 0.0, grain: Grain::default() };
    /// assert_eq!((law.line().limit_n, law.line().sigma), (3.0, 5e4));
    /// ```
    pub fn line(&self) -> crate::Dahl<S> {
        crate::Dahl {
            limit_p: self.limit,
            limit_n: self.limit,
            sigma: self.sigma,
            exponent: self.exponent,
            viscous: self.viscous,
        }
    }
}

impl<S: Scalar> FrictionLaw<S> for Dahl<S> {
    type State = DahlState<S>;

    fn step(&self, state: &mut DahlState<S>, motion: &Motion<S>) -> Vector<S> {
        if !motion.is_finite() {
            return Vector::nan();
        }
        let (zero, limit) = (S::zero(), self.limit);
        let (distance, direction) = self.grain.slip(motion.displacement).polar();
        let z = state.z.within(limit);
        state.z = if distance > zero {
            let end = direction * limit;
            let gap = end - z;
            let length = gap.norm();
            let left = if length > zero && limit > zero {
                gap * self.line().decay(length, limit, distance)
            } else {
                Vector::default()
            };
            (end - left).within(limit)
        } else {
            z
        };
        self.grain.force(state.z + self.grain.slip(motion.velocity) * self.viscous)
    }

    fn validate(&self) -> Result<(), Invalid> {
        self.line().validate().map_err(without_direction)?;
        self.grain.validate()
    }
}
