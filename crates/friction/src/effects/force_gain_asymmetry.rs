//! Different gains for push and pull, as of a load cell or a bridge.

use super::{About, Acts, Describe, Parameter, Quantity, Seat};
use crate::Dimension;

/// A force channel with another gain for one sign of the force: against that sign, and not against the velocity's.
///
/// ```
/// # #[cfg(feature = "alloc")] {
/// use friction::effects::{Record, SeriesKind};
///
/// let (force, rest) = ([-2.0, 0.0, 2.0], [0.0; 3]);
/// let record = Record { dt: 1e-3, position: &rest, acceleration: &rest, direction: &rest, force: &force };
/// assert_eq!(SeriesKind::ForceGainAsymmetry.added(0, &[0.0; 2], &record), [0.0, 0.0, 2.0]); // N
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ForceGainAsymmetry;

impl Describe for ForceGainAsymmetry {
    const ABOUT: About = About {
        id: "force_gain_asymmetry",
        says: "the force channel has another gain for one sign of the force",
        equation: "F = F_model + gain·max(F_model, 0)",
        shows: "against the sign of the force",
        confused_with: "position_dependent_friction (1.0 on one sine)",
        told_apart_by: "weights both ways",
        gains: &[Parameter::gain("gain", Dimension::NUMBER, (-1.0, 1.0), "extra gain for positive force")],
        reads: &[Quantity::Force],
        seat: Seat::Channel(Quantity::Force),
        acts: Acts::OnForce,
        ..About::EFFECT
    };
}

#[cfg(feature = "alloc")]
impl super::series::Operator for ForceGainAsymmetry {
    fn added(_gain: usize, _shape: &[f64; 2], record: &super::Record<'_>) -> alloc::vec::Vec<f64> {
        record.force.iter().map(|f| f.max(0.0)).collect()
    }
}
