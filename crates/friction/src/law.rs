//! What every friction law is: configuration, apart from its state, stepped by the relative motion.

use crate::Scalar;
use core::fmt;

/// The relative motion of a sliding body over one time step: everything a law may look at.
///
/// Sign: a law returns the friction force *opposing* positive motion, so that m·a = F_applied − F_friction
/// (eq. 3.4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<S> {
    /// Length of the step, s.
    pub dt: S,
    /// Position of the body on the surface, m (or rad).
    pub position: S,
    /// Distance slid during the step, m. Exact where an encoder measures it, else `velocity · dt`.
    pub displacement: S,
    /// Velocity of the body relative to the surface, m/s.
    pub velocity: S,
    /// F_a of eq. 3.1: the sum of the non-frictional forces on the body, N.
    pub applied: S,
    /// Mass that a stopping force has to stop, kg. Zero: the law may only balance `applied`.
    pub mass: S,
    /// Normal load, N, where it is known.
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
    /// The friction that would bring the body to rest at the end of this step: m v / dt + F_a, N. F_a alone where
    /// there is no mass or no time.
    #[inline(always)]
    pub fn stopping_force(&self) -> S {
        if self.mass > S::zero() && self.dt > S::zero() {
            self.mass * self.velocity / self.dt + self.applied
        } else {
            self.applied
        }
    }

    /// Whether every number that is there is finite. A law answers a motion that is not with NaN and keeps its
    /// memory as it was, so one bad sample shows and does not last.
    #[inline(always)] // where a motion was just put together, it is in registers
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

/// A friction law. `self` is configuration and never changes during a step; what the law remembers is in
/// `State`. No clock, no I/O, no global.
pub trait FrictionLaw<S: Scalar> {
    /// Memory of the law; `default()` is a body at rest on a fresh contact.
    type State: Copy + Default + fmt::Debug + PartialEq;

    /// Advances the law by `motion.dt` and returns the friction force in N, positive against positive motion.
    fn step(&self, state: &mut Self::State, motion: &Motion<S>) -> S;

    /// Checks every parameter for finiteness and physical range.
    ///
    /// # Errors
    /// The first parameter that is out of range, with the range that would be accepted.
    fn validate(&self) -> Result<(), Invalid>;
}

/// A parameter that was refused, and what would be accepted instead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Invalid {
    /// Name of the parameter as a user types it.
    pub parameter: &'static str,
    /// The value that was refused.
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

/// Refuses `value` unless it is finite and within `[min, max]`.
///
/// # Errors
/// [`Invalid`] naming the parameter and the accepted range.
pub fn in_range<S: Scalar>(parameter: &'static str, value: S, min: f64, max: f64) -> Result<(), Invalid> {
    // in `S`: a limit that is typed is within, and `f64` is software on the target
    if value.is_finite() && value >= S::lit(min) && value <= S::lit(max) {
        Ok(())
    } else {
        Err(Invalid { parameter, value: value.re(), min, max })
    }
}

/// A law given as a closure of the motion, for plants and tests that bring their own physics.
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
