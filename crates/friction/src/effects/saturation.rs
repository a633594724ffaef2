//! A limit of the force below what was commanded.

use super::{About, Acts, Describe, Parameter, Quantity, Scale, Seat};
use crate::Dimension;

/// A limit of the force below what was commanded: only at peak force.
///
/// ```
/// # #[cfg(feature = "alloc")] {
/// use friction::effects::{Record, SeriesKind};
///
/// let (force, rest) = ([-11.0, 3.0, 10.0], [0.0; 3]);
/// let record = Record { dt: 1e-3, position: &rest, acceleration: &rest, direction: &rest, force: &force };
/// assert_eq!(SeriesKind::Saturation.added(0, &[9.0, 0.0], &record), [-2.0, 0.0, 1.0]); // N beyond the limit of 9 N
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Saturation;

impl Describe for Saturation {
    const ABOUT: About = About {
        id: "saturation",
        says: "the force stops growing at a limit that the recording does not show",
        equation: "F = F_model + share·(|F_model| − limit)₊·sgn F_model",
        shows: "only at peak force",
        confused_with: "a cubic in F (.93)",
        told_apart_by: "an amplitude ladder",
        gains: &[Parameter::gain(
            "share",
            Dimension::NUMBER,
            (-2.0, 0.0),
            "minus the share of the excess that is cut; −1 is a hard limit, beyond only by noise",
        )],
        shape: &[Parameter::shape("limit", Scale::Force, (1e-9, 1e9), "force beyond which it is cut")],
        reads: &[Quantity::Force],
        seat: Seat::Drive,
        acts: Acts::OnForce,
        ..About::EFFECT
    };
}

#[cfg(feature = "alloc")]
impl super::series::Operator for Saturation {
    fn added(_gain: usize, &[limit, _]: &[f64; 2], record: &super::Record<'_>) -> alloc::vec::Vec<f64> {
        record.force.iter().map(|f| (f.abs() - limit).max(0.0) * f.signum()).collect()
    }
}
