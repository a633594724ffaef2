//! The trait of every friction law, and the motion a law is stepped with.

use crate::Scalar;
use core::fmt;

/// Relative motion of a sliding body over one time step: the only input of a law.
///
/// A law returns the friction force *opposing* positive motion: m·a = F_applied − F_friction [thesis, eq. 3.4].
///
/// ```
/// let motion = friction::Motion { velocity: 0.1, ..friction::Motion::default() };
/// assert_eq!((motion.velocity, motion.mass, motion.normal), (0.1, 0.0, None));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<S> {
    /// Length of the step, s.
    pub dt: S,
    /// Position of the body on the surface, m; rad on a rotary axis.
    pub position: S,
    /// Distance slid during the step, m. Exact where an encoder measures it, otherwise `velocity · dt`.
    pub displacement: S,
    /// Velocity of the body relative to the surface, m/s.
    pub velocity: S,
    /// Sum of the forces on the body other than friction, F_a of [thesis, eq. 3.1], N.
    pub applied: S,
    /// Mass that a stopping force acts on, kg. With zero the law can only balance `applied`.
    pub mass: S,
    /// Normal load, N, if known.
    pub normal: Option<S>,
}

impl<S: Scalar> Default for Motion<S> {
    fn default() -> Self {
        let zero = S::zero();
        Self {
            dt: zero,
            position: zero,
            displacement: zero,
            velocity: zero,
            applied: zero,
            mass: zero,
            normal: None,
        }
    }
}

impl<S: Scalar> Motion<S> {
    /// Friction that would bring the body to rest at the end of this step, m v / dt + F_a, N. F_a where mass or time
    /// step is zero.
    ///
    /// ```
    /// use friction::Motion;
    /// let motion = Motion { dt: 1e-3, velocity: 0.01, applied: 1.0, mass: 0.5, ..Motion::default() };
    /// assert!((motion.stopping_force() - 6.0_f64).abs() < 1e-12);
    /// ```
    #[inline(always)]
    pub fn stopping_force(&self) -> S {
        if self.mass > S::zero() && self.dt > S::zero() {
            self.mass * self.velocity / self.dt + self.applied
        } else {
            self.applied
        }
    }

    /// Whether every number is finite. A law answers a non-finite motion with NaN and keeps its state: a bad sample is
    /// visible and has no lasting effect.
    ///
    /// ```
    /// use friction::Motion;
    /// assert!(Motion::<f64>::default().is_finite());
    /// assert!(!Motion { velocity: f64::NAN, ..Motion::default() }.is_finite());
    /// ```
    #[inline(always)] // a motion that was just built is in registers
    pub fn is_finite(&self) -> bool {
        let normal = self.normal.unwrap_or(S::zero());
        S::are_finite([
            self.dt,
            self.position,
            self.displacement,
            self.velocity,
            self.applied,
            self.mass,
            normal,
        ])
    }
}

/// A friction law. `self` is configuration and constant during a step; the memory of the law is `State`. No clock, no I/O,
/// no global.
///
/// ```
/// use friction::{FrictionLaw, Invalid, Motion, in_range};
/// /// Friction proportional to the normal load.
/// struct Amontons { coefficient: f64 }
/// impl FrictionLaw<f64> for Amontons {
///     type State = ();
///     fn step(&self, (): &mut (), motion: &Motion<f64>) -> f64 {
///         self.coefficient * motion.normal.unwrap_or(0.0) * motion.velocity.signum()
///     }
///     fn validate(&self) -> Result<(), Invalid> {
///         in_range("coefficient", self.coefficient, 0.0, 10.0)
///     }
/// }
/// let law = Amontons { coefficient: 0.3 };
/// let sliding = Motion { velocity: -0.1, normal: Some(4.0), ..Motion::default() };
/// assert!((law.step(&mut (), &sliding) + 1.2).abs() < 1e-12);
/// ```
pub trait FrictionLaw<S: Scalar> {
    /// Memory of the law. `default()` is a body at rest on a fresh contact.
    type State: Copy + Default + fmt::Debug + PartialEq;

    /// Advances the law by `motion.dt` and returns the friction force in N, positive against positive motion.
    fn step(&self, state: &mut Self::State, motion: &Motion<S>) -> S;

    /// Energy in the springs of the contact, which a body may get back, J.
    fn stored(&self, _state: &Self::State) -> S {
        S::zero()
    }

    /// Checks every parameter for finiteness and physical range.
    ///
    /// # Errors
    /// The first parameter that is out of range, with the range that would be accepted.
    fn validate(&self) -> Result<(), Invalid>;
}

/// A rejected parameter and the range that would be accepted.
///
/// ```
/// let error = friction::in_range("sigma", -1.0, 0.0, 1e12).unwrap_err();
/// assert_eq!(error.to_string(), "sigma = -1: accepted from 0 to 1000000000000");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Invalid {
    /// Name of the parameter as a user types it.
    pub parameter: &'static str,
    /// The rejected value.
    pub value: f64,
    /// Smallest accepted value.
    pub min: f64,
    /// Largest accepted value.
    pub max: f64,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}: accepted from {} to {}", self.parameter, self.value, self.min, self.max)
    }
}

impl core::error::Error for Invalid {}

/// Checks that `value` is finite and within `[min, max]`.
///
/// # Errors
/// [`Invalid`] with the parameter and the accepted range.
///
/// ```
/// assert!(friction::in_range("dt", 1e-3_f64, 0.0, 1.0).is_ok());
/// assert!(friction::in_range("dt", f64::INFINITY, 0.0, 1.0).is_err());
/// ```
pub fn in_range<S: Scalar>(parameter: &'static str, value: S, min: f64, max: f64) -> Result<(), Invalid> {
    // compared in `S`: a typed limit is accepted, and `f64` is software on the target
    if value.is_finite() && value >= S::lit(min) && value <= S::lit(max) {
        Ok(())
    } else {
        Err(Invalid { parameter, value: value.re(), min, max })
    }
}

/// A law given as a closure of the motion, for plants and tests with their own physics.
///
/// ```
/// use friction::{Custom, FrictionLaw, Motion};
/// let cubic = Custom(|motion: &Motion<f64>| 50.0 * motion.velocity.powi(3));
/// let force = cubic.step(&mut (), &Motion { velocity: 0.2, ..Motion::default() });
/// assert!((force - 0.4).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Custom<F>(
    /// Friction force in N from the motion.
    pub F,
);

impl<S: Scalar, F: Fn(&Motion<S>) -> S> FrictionLaw<S> for Custom<F> {
    type State = ();

    fn step(&self, (): &mut (), motion: &Motion<S>) -> S {
        (self.0)(motion)
    }

    fn validate(&self) -> Result<(), Invalid> {
        Ok(())
    }
}
