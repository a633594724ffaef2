//! The trait of every law in the plane, and the motion it is stepped with.

use super::Vector;
use crate::{Invalid, Scalar};
use core::fmt;

/// Motion of a body over one time step, as [`crate::Motion`] with vectors for what has a direction.
///
/// ```
/// use friction::planar::{Motion, Vector};
/// let motion = Motion { velocity: Vector { x: 0.1, y: 0.0 }, ..Motion::default() };
/// assert_eq!((motion.velocity.norm(), motion.mass), (0.1, 0.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<S> {
    /// Length of the step, s.
    pub dt: S,
    /// Position of the body on the surface, m.
    pub position: Vector<S>,
    /// Path of the step, m: straight.
    pub displacement: Vector<S>,
    /// Velocity of the body relative to the surface, m/s.
    pub velocity: Vector<S>,
    /// Sum of the forces on the body other than friction, N.
    pub applied: Vector<S>,
    /// Mass that a stopping force acts on, kg, the same in every direction. With zero the law can only balance `applied`.
    pub mass: S,
    /// Normal load, N, if known.
    pub normal: Option<S>,
}

impl<S: Scalar> Default for Motion<S> {
    fn default() -> Self {
        let (zero, still) = (S::zero(), Vector::default());
        Self {
            dt: zero,
            position: still,
            displacement: still,
            velocity: still,
            applied: still,
            mass: zero,
            normal: None,
        }
    }
}

impl<S: Scalar> Motion<S> {
    /// The motion along one axis: `component` of every vector.
    ///
    /// ```
    /// use friction::planar::{Motion, Vector};
    /// let motion = Motion { velocity: Vector { x: 0.1, y: 0.2 }, ..Motion::default() };
    /// assert_eq!(motion.axis(|v| v.y).velocity, 0.2);
    /// ```
    pub fn axis(&self, component: impl Fn(Vector<S>) -> S) -> crate::Motion<S> {
        crate::Motion {
            dt: self.dt,
            position: component(self.position),
            displacement: component(self.displacement),
            velocity: component(self.velocity),
            applied: component(self.applied),
            mass: self.mass,
            normal: self.normal,
        }
    }

    /// Friction that would bring the body to rest at the end of this step, m v/dt + F_a, N.
    ///
    /// ```
    /// use friction::planar::{Motion, Vector};
    /// let velocity = Vector { x: 0.0, y: 0.01 };
    /// let motion = Motion { dt: 1e-3, velocity, mass: 0.5, ..Motion::default() };
    /// assert!((motion.stopping_force().y - 5.0_f64).abs() < 1e-12);
    /// ```
    pub fn stopping_force(&self) -> Vector<S> {
        Vector { x: self.axis(|v| v.x).stopping_force(), y: self.axis(|v| v.y).stopping_force() }
    }

    /// Whether every number is finite. A law answers a motion that is not with NaN and keeps its state.
    ///
    /// ```
    /// use friction::planar::Motion;
    /// assert!(Motion::<f64>::default().is_finite());
    /// assert!(!Motion { dt: f64::NAN, ..Motion::default() }.is_finite());
    /// ```
    pub fn is_finite(&self) -> bool {
        self.axis(|v| v.x).is_finite() && self.axis(|v| v.y).is_finite()
    }
}

/// A law of friction in the plane, as [`crate::FrictionLaw`] is one on a line.
///
/// ```
/// use friction::planar::{FrictionLaw, Motion, Vector};
/// /// A film of oil.
/// struct Film { viscous: f64 }
/// impl FrictionLaw<f64> for Film {
///     type State = ();
///     fn step(&self, (): &mut (), motion: &Motion<f64>) -> Vector<f64> {
///         motion.velocity * self.viscous
///     }
///     fn validate(&self) -> Result<(), friction::Invalid> {
///         friction::in_range("viscous", self.viscous, 0.0, 1e6)
///     }
/// }
/// let motion = Motion { velocity: Vector { x: 0.1, y: -0.2 }, ..Motion::default() };
/// assert_eq!(Film { viscous: 10.0 }.step(&mut (), &motion), Vector { x: 1.0, y: -2.0 });
/// ```
pub trait FrictionLaw<S: Scalar> {
    /// Memory of the law. `default()` is a body at rest on a fresh contact.
    type State: Copy + Default + fmt::Debug + PartialEq;

    /// Advances the law by `motion.dt` and returns the friction force in N, which the body feels with the opposite sign.
    fn step(&self, state: &mut Self::State, motion: &Motion<S>) -> Vector<S>;

    /// Checks every parameter for finiteness and physical range.
    ///
    /// # Errors
    /// The first parameter that is out of range, with the range that would be accepted.
    fn validate(&self) -> Result<(), Invalid>;
}

/// A refusal by the law on a line, in terms of the law in the plane, which has one parameter for both directions.
pub(super) fn without_direction(refused: Invalid) -> Invalid {
    Invalid { parameter: refused.parameter.strip_suffix("_p").unwrap_or(refused.parameter), ..refused }
}
