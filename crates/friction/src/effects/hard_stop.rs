//! The end of the stroke.
//!
//! F = k_p·max(x − x_max, 0) − k_n·max(x_min − x, 0).
//!
//! * Signature: one-sided, at the end of the stroke, nothing elsewhere.
//! * Confused with: nonlinear_spring (.68-.85).
//! * Told apart by: going there.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature};
use crate::{Invalid, Motion, Scalar};

/// Elastic stops at both ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HardStop;

impl Signature for HardStop {
    const ID: &'static str = "hard_stop";
    const SAYS: &'static str = "The moving part runs into a stop at the end of its stroke.";
    const EQUATION: &'static str = "k_p*max(x - x_max, 0) - k_n*max(x_min - x, 0)";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("k_p", "N/m", (0.0, 1e9), "stiffness of the stop at the positive end"),
        Parameter::new("k_n", "N/m", (0.0, 1e9), "stiffness of the stop at the negative end"),
    ];
    const SHAPE: &'static [Parameter] = &[
        Parameter::new("x_max", "m", (-1e3, 1e3), "where the positive stop begins"),
        Parameter::new("x_min", "m", (-1e3, 1e3), "where the negative stop begins"),
    ];

    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [x_max, x_min] = *shape;
        let (x, zero) = (motion.position, S::zero());
        [(x - x_max).max(zero), (x - x_min).min(zero), zero, zero]
    }

    fn check_shape<S: Scalar>(&[x_max, x_min]: &[S; MAX_SHAPE]) -> Result<(), Invalid> {
        if x_max >= x_min {
            Ok(())
        } else {
            Err(Invalid { parameter: "x_max", value: x_max.re(), min: x_min.re(), max: 1e3 })
        }
    }
}
