//! Elasto-plastic friction in the plane.

use super::lugre::bristles;
use super::{FrictionLaw, Grain, Motion, Vector};
use crate::{FrictionLaw as _, Invalid, Scalar};
use serde::{Deserialize, Serialize};

/// Elasto-plastic friction [dupont-2002] in the plane, see [`crate::ElastoPlastic`].
///
/// ```text
/// dz/ds = n − α(|z|) (z·n)₊/|z| z/z_ss,   n the direction of motion
/// ```
///
/// The deflection flows back along itself, as in associated plasticity with a disc: elastic in |z| ≤ z_ba and wherever the
/// deflection shrinks; on the circle |z| = z_ss it turns towards the motion. A load that vibrates or turns below z_ba does
/// not move the contact.
///
/// ```
/// use friction::planar::{ElastoPlastic, ElastoPlasticState, FrictionLaw, Grain, Motion, Vector};
/// let lugre = friction::LuGre {
///     sigma_0: 1e5, sigma_1: 0.0, sigma_2: 0.0, coulomb: 1.0, stiction: 1.0, stribeck_velocity: 1e-3,
/// };
/// let law = ElastoPlastic { contact: friction::ElastoPlastic::of(lugre, 0.8), grain: Grain::default() };
/// let mut state = ElastoPlasticState::default();
/// // around a square below z_ba: the spring σ₀ in every direction, and back at the start without a force
/// let (a, o) = (5e-6, 0.0);
/// let forces = [(a, o), (o, a), (-a, o), (o, -a)]
///     .map(|(x, y)| law.step(&mut state, &Motion { displacement: Vector { x, y }, ..Motion::default() }));
/// assert!((forces[1].norm() - 0.5_f64 * 2.0_f64.sqrt()).abs() < 1e-12 && forces[3].norm() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ElastoPlastic<S> {
    /// The contact along the grain.
    pub contact: crate::ElastoPlastic<S>,
    /// The grain. The default is none.
    pub grain: Grain<S>,
}

/// State of [`ElastoPlastic`].
///
/// ```
/// let fresh = friction::planar::ElastoPlasticState::<f32>::default();
/// assert_eq!(fresh.z.norm(), 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElastoPlasticState<S> {
    /// Mean deflection of the bristles along and across the grain, in the coordinates of [`Grain::slip`], m.
    pub z: Vector<S>,
}

impl<S: Scalar> Default for ElastoPlasticState<S> {
    fn default() -> Self {
        Self { z: Vector::default() }
    }
}

impl<S: Scalar> FrictionLaw<S> for ElastoPlastic<S> {
    type State = ElastoPlasticState<S>;

    fn step(&self, state: &mut ElastoPlasticState<S>, motion: &Motion<S>) -> Vector<S> {
        if !motion.is_finite() {
            return Vector::nan();
        }
        let (zero, law) = (S::zero(), &self.contact);
        let slip = self.grain.slip(motion.velocity);
        let (distance, n) = self.grain.slip(motion.displacement).polar();
        let across = Vector { x: -n.y, y: n.x };
        let before = state.z.within(law.stiction / law.sigma_0);
        state.z = if distance > zero {
            let steady = law.level(slip.norm()) / law.sigma_0;
            // a deflection that points away from the motion shrinks by itself
            let start = if before.dot(n) > zero { before.within(steady.max(zero)) } else { before };
            let (along, side) = law.slid(start.dot(n), start.dot(across), distance, steady);
            n * along + across * side
        } else {
            before
        };
        self.grain.force(bristles(&law.bristles(), before, state.z, motion.dt, slip))
    }

    fn validate(&self) -> Result<(), Invalid> {
        self.contact.validate()?;
        self.grain.validate()
    }
}
