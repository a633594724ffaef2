//! The end of the stroke.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, Describe, Parameter, EITHER_OR_BOTH, Quantity, Scale, Seat};
use crate::{Dimension, Invalid, Motion, Scalar};

/// Elastic stops at both ends.
///
/// F = k_p·max(x − x_max, 0) − k_n·max(x_min − x, 0).
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let stops = Effect { kind: EffectKind::HardStop, gains: [5e3, 5e3, 0.0, 0.0], shape: [0.015, -0.015] };
/// let beyond = Motion { position: 0.0151, ..Motion::default() };
/// let force: f64 = stops.step(&mut EffectState::default(), &beyond);
/// assert!((force - 0.5).abs() < 1e-9); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HardStop;

impl Describe for HardStop {
    const ABOUT: About = About {
        id: "hard_stop",
        says: "The moving part runs into a stop at the end of its stroke.",
        equation: "k_p*max(x - x_max, 0) - k_n*max(x_min - x, 0)",
        shows: "one-sided, at the end of the stroke, nothing elsewhere",
        confused_with: "nonlinear_spring (.68-.85)",
        told_apart_by: "going there",
        gains: &[
            Parameter::gain("k_p", Dimension::STIFFNESS, (0.0, 1e9), "stiffness of the stop at the positive end"),
            Parameter::gain("k_n", Dimension::STIFFNESS, (0.0, 1e9), "stiffness of the stop at the negative end"),
        ],
        groups: EITHER_OR_BOTH,
        shape: &[
            Parameter::shape("x_max", Scale::Place { from: 60, to: 98 }, (-1e3, 1e3), "where the positive stop begins"),
            Parameter::shape("x_min", Scale::Place { from: 2, to: 40 }, (-1e3, 1e3), "where the negative stop begins"),
        ],
        reads: &[Quantity::Position],
        seat: Seat::Body,
        ..About::EFFECT
    };
}

impl Signature for HardStop {
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
