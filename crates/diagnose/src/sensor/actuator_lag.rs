//! A lag 1/(T·s + 1) between the recorded force and the one that acts: an actuator that follows its recorded command
//! late, or a force channel behind a low-pass of first order. A phase that bends; confused with `time_skew`; told apart
//! above 1/(2πT).
//!
//! The command runs ahead of the force by exactly T·dF/dt; what a channel shows is the force behind the exact lag.

use super::{Acts, Sensor, true_force};
use crate::signal::derivative;
use crate::track::Track;
use friction::effects::Parameter;
use identify::dynamics::first_order_lag;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "actuator_lag",
    acts: Acts::InTime,
    says: "a first-order lag lies between the recorded force and the one that acts",
    equation: "F = F_model + T·dF_model/dt of a recorded command, F = F_model/(T·s + 1) of a channel, T = lag",
    gains: &[
        Parameter {
            name: "command",
            unit: "1",
            min: 0.0,
            max: super::MOST_SHARE,
            what: "share of the force that follows a recorded command; 1 but for noise",
        },
        Parameter {
            name: "channel",
            unit: "1",
            min: 0.0,
            max: super::MOST_SHARE,
            what: "share of the force that its channel shows late",
        },
    ],
    shape: &[Parameter { name: "lag", unit: "s", min: 1e-5, max: 0.5, what: "time constant T" }],
    columns,
};

fn columns(track: &Track, shape: &[f64; 2]) -> Vec<Vec<f64>> {
    let (dt, time) = (track.raw.dt, shape[0]);
    let commanded = true_force(track, &first_order_lag(&track.f, time, dt));
    let command = derivative(&commanded, dt).iter().map(|rate| time * rate).collect();
    let rate = derivative(&track.f, dt);
    let sensed: Vec<f64> = track.f.iter().zip(&rate).map(|(f, rate)| f + time * rate).collect();
    let sensed = true_force(track, &sensed);
    let channel = first_order_lag(&sensed, time, dt).iter().zip(&sensed).map(|(slow, f)| slow - f).collect();
    vec![command, channel]
}
