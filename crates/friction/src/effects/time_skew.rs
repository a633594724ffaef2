//! A force channel and motion channels that are not simultaneous.

use super::{About, Acts, Describe, EITHER, Parameter, Quantity, Scale, Seat};
use crate::Dimension;

/// The force, recorded at another moment than the position.
///
/// The shift is exact, not its first term −τ·dF/dt: at a third of a period that is wrong by half, and the phase is what
/// tells a delay from a lag.
///
/// ```
/// # #[cfg(feature = "alloc")] {
/// use friction::effects::{Record, SeriesKind};
///
/// let force: Vec<f64> = (0..9).map(|i| f64::from(i) * 0.5).collect();
/// let rest = [0.0; 9];
/// let record = Record { dt: 1e-3, position: &rest, acceleration: &rest, direction: &rest, force: &force };
/// let behind = SeriesKind::TimeSkew.added(0, &[2e-3, 0.0], &record);
/// assert_eq!(behind[5], -1.0); // N: two samples late on a ramp of 0.5 N a sample
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeSkew;

impl Describe for TimeSkew {
    const ABOUT: About = About {
        id: "time_skew",
        says: "the force was recorded at another moment than the position",
        equation: "F(t) = F_model(t − tau) behind, F_model(t + tau) ahead",
        shows: "grows with the rate of the force; worst at the edges of the acceleration",
        confused_with: "actuator_lag (.87-.94), an anti-aliasing filter on one channel (.97)",
        told_apart_by: "its phase, which grows linearly with frequency: a move that contains one fast component",
        gains: &[
            Parameter::gain(
                "behind",
                Dimension::NUMBER,
                (0.0, super::MOST_SHARE),
                "share of the force that is late; 1 but for noise",
            ),
            Parameter::gain("ahead", Dimension::NUMBER, (0.0, super::MOST_SHARE), "share that is early"),
        ],
        groups: EITHER,
        shape: &[Parameter::shape("tau", Scale::Lag, (1e-6, 1.0), "time lag between force and position")],
        reads: &[Quantity::Force, Quantity::Time],
        seat: Seat::Channel(Quantity::Force),
        acts: Acts::Delay,
        ..About::EFFECT
    };
}

#[cfg(feature = "alloc")]
mod operator {
    use super::TimeSkew;
    use crate::effects::series::{Operator, Record, delayed, difference};
    use alloc::vec::Vec;

    /// Late by this much.
    fn late(gain: usize, tau: f64) -> f64 {
        if gain == 0 { tau } else { -tau }
    }

    impl Operator for TimeSkew {
        fn added(gain: usize, &[tau, _]: &[f64; 2], record: &Record<'_>) -> Vec<f64> {
            difference(&delayed(record.force, late(gain, tau), record.dt), record.force)
        }

        fn restored(gain: usize, &[tau, _]: &[f64; 2], shown: &[f64], dt: f64) -> Vec<f64> {
            delayed(shown, -late(gain, tau), dt)
        }

        fn delay(gains: &[f64], &[tau, _]: &[f64; 2]) -> f64 {
            gains.iter().enumerate().map(|(gain, share)| share * late(gain, tau)).take(2).sum()
        }
    }
}
