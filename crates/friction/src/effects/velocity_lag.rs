//! A velocity estimator that lags.

use super::{About, Acts, Comparison, Describe, Parameter, Quantity, Scale, Seat};
use crate::Dimension;

/// The lag of a velocity channel: a spike of twice the Coulomb force at every reversal, as long as the lag.
///
/// ```
/// # #[cfg(feature = "alloc")] {
/// use friction::effects::{Record, SeriesKind};
///
/// let direction = [1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0];
/// let rest = [0.0; 8];
/// let record = Record { dt: 1e-3, position: &rest, acceleration: &rest, direction: &direction, force: &rest };
/// let spike = SeriesKind::VelocityLag.added(0, &[2e-3, 0.0], &record);
/// assert_eq!(spike, [0.0, 0.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0]);
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VelocityLag;

impl Describe for VelocityLag {
    const ABOUT: About = About {
        id: "velocity_lag",
        says: "the velocity channel lags, so friction seems to reverse late",
        equation: "F = F_model + force·(sgn v(t − lag) − sgn v(t))",
        shows: "a spike at every reversal",
        confused_with: "frictional_lag (1.0 on one sine), presliding",
        told_apart_by: "recomputing the velocity from the position; moves with dwells",
        gains: &[Parameter::gain(
            "force",
            Dimension::FORCE,
            (-1e6, 1e6),
            "Coulomb level seen through the lag",
        )],
        shape: &[Parameter::shape("lag", Scale::Lag, (1e-4, 0.2), "lag of the velocity")],
        reads: &[Quantity::Velocity, Quantity::Time],
        seat: Seat::Channel(Quantity::Velocity),
        acts: Acts::OnMotion,
        bench_test: Some("record the velocity channel too: `velocity_m_s` beside the position"),
        comparison: Some(Comparison {
            equation: "v_column(t) = v(t − lag), v the derivative of the position",
            parameters: &[Parameter::shape("lag", Scale::Lag, (1e-4, 0.2), "lag of the velocity")],
            confirmed_by: "no move is needed: recompute the velocity from the position, or set the estimator's filter faster",
        }),
        ..About::EFFECT
    };
}

#[cfg(feature = "alloc")]
impl super::series::Operator for VelocityLag {
    fn added(_gain: usize, &[lag, _]: &[f64; 2], record: &super::Record<'_>) -> alloc::vec::Vec<f64> {
        super::series::difference(&super::delayed(record.direction, lag, record.dt), record.direction)
    }
}
