//! A spring that stiffens with deflection.
//!
//! F = cubic·x³ + quadratic·x².
//!
//! * Signature: even in v, against x, growing toward the ends.
//! * Confused with: spring, hard_stop (.68-.85).
//! * Told apart by: a ladder of amplitudes.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature};
use crate::{Motion, Scalar};

/// A spring that stiffens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NonlinearSpring;

impl Signature for NonlinearSpring {
    const ID: &'static str = "nonlinear_spring";
    const SAYS: &'static str = "Something pulls back with position, and stiffens toward the ends.";
    const EQUATION: &'static str = "cubic*x^3 + quadratic*x^2";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("cubic", "N/m³", (-1e12, 1e12), "cubic stiffness"),
        Parameter::new("quadratic", "N/m²", (-1e12, 1e12), "quadratic stiffness"),
    ];
    const SHAPE: &'static [Parameter] = &[];

    fn unit<S: Scalar>(
        _shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let (x, zero) = (motion.position, S::zero());
        [x * x * x, x * x, zero, zero]
    }
}
