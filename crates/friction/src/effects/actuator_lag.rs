//! A first-order lag between the recorded force and the one that acts.

use super::{About, Acts, Describe, EITHER, Parameter, Quantity, Scale, Seat};
use crate::Dimension;

/// A lag 1/(T·s + 1): an actuator that follows its recorded command late, or a force channel behind a low-pass of first
/// order.
///
/// The command runs ahead of the force by exactly T·dF/dt; what a channel shows is the force behind the exact lag.
///
/// ```
/// # #[cfg(feature = "alloc")] {
/// use friction::effects::{Record, SeriesKind};
///
/// let force: Vec<f64> = (0..500).map(|i| f64::from(i) * 1e-3).collect();
/// let rest = [0.0; 500];
/// let record = Record { dt: 1e-3, position: &rest, acceleration: &rest, direction: &rest, force: &force };
/// let channel = SeriesKind::ActuatorLag.added(1, &[0.02, 0.0], &record);
/// assert!((channel[499] + 0.02).abs() < 1e-9); // N: a ramp of 1 N/s comes late by the time constant
/// # }
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ActuatorLag;

impl Describe for ActuatorLag {
    const ABOUT: About = About {
        id: "actuator_lag",
        says: "a first-order lag lies between the recorded force and the one that acts",
        equation: "F = F_model + command·lag·dF_model/dt of a recorded command, F = F_model + channel·(F_model/(lag·s + 1) − F_model) of a channel",
        shows: "in proportion to dF/dt, with a phase that bends",
        confused_with: "time_skew (.87-.94)",
        told_apart_by: "motion above 1/(2π·lag)",
        gains: &[
            Parameter::gain(
                "command",
                Dimension::NUMBER,
                (0.0, super::MOST_SHARE),
                "share of the force that follows a recorded command; 1 but for noise",
            ),
            Parameter::gain(
                "channel",
                Dimension::NUMBER,
                (0.0, super::MOST_SHARE),
                "share of the force that its channel shows late",
            ),
        ],
        groups: EITHER,
        shape: &[Parameter::shape("lag", Scale::Lag, (1e-5, 0.5), "time constant")],
        reads: &[Quantity::Force, Quantity::Time],
        seat: Seat::Drive,
        acts: Acts::Lag,
        ..About::EFFECT
    };
}

#[cfg(feature = "alloc")]
mod operator {
    use super::ActuatorLag;
    use crate::Scalar;
    use crate::effects::series::{Operator, Record, derivative, difference};
    use crate::mean_decay;
    use alloc::vec::Vec;

    /// A series behind a first-order lag with time constant `lag`, s, started in its steady state; exact for a signal that
    /// is straight between samples, so that a ramp comes late by the time constant and not by half a sample less.
    fn behind(series: &[f64], lag: f64, dt: f64) -> Vec<f64> {
        let in_lags = dt / lag.max(1e-300);
        let (keep, mean) = (Scalar::exp(-in_lags), mean_decay(in_lags));
        let mut before = series.first().copied().unwrap_or(0.0);
        let mut state = before;
        series
            .iter()
            .map(|&x| {
                state = keep * state + (mean - keep) * before + (1.0 - mean) * x;
                before = x;
                state
            })
            .collect()
    }

    /// A series ahead of a first-order lag.
    fn ahead(series: &[f64], lag: f64, dt: f64) -> Vec<f64> {
        series.iter().zip(derivative(series, dt)).map(|(f, rate)| f + lag * rate).collect()
    }

    impl Operator for ActuatorLag {
        fn added(gain: usize, &[lag, _]: &[f64; 2], record: &Record<'_>) -> Vec<f64> {
            if gain == 0 {
                derivative(record.force, record.dt).iter().map(|rate| lag * rate).collect()
            } else {
                difference(&behind(record.force, lag, record.dt), record.force)
            }
        }

        fn restored(gain: usize, &[lag, _]: &[f64; 2], shown: &[f64], dt: f64) -> Vec<f64> {
            if gain == 0 { behind(shown, lag, dt) } else { ahead(shown, lag, dt) }
        }

        fn low_pass(gains: &[f64], &[lag, _]: &[f64; 2]) -> Option<f64> {
            gains.get(1).is_some_and(|channel| *channel > 0.0).then_some(lag)
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn a_ramp_is_late_by_the_time_constant() {
            let dt = 1e-3;
            let ramp: Vec<f64> = (0..400).map(|i| f64::from(i) * dt).collect();
            for lag in [0.3e-3, 1.6e-3, 20e-3] {
                let late = ramp[399] - behind(&ramp, lag, dt)[399];
                std::println!("{lag} s: {late:.6} s late");
                assert!((late - lag).abs() < 1e-9);
            }
        }
    }
}
