//! The recorded force is a command, and the actuator lags behind it: 1/(T·s + 1). e ≈ T·dF/dt with a phase that
//! bends; confused with `time_skew`; told apart above 1/(2πT).

use super::Sensor;
use crate::track::Track;
use friction::effects::Parameter;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "actuator_lag",
    says: "the actuator follows its command through a lag",
    equation: "F = F_model + g·(1 − 1/(T·s + 1))·F_model",
    gains: &[Parameter {
        name: "share",
        unit: "1",
        min: -1.1,
        max: 2.0,
        what: "share of the force that lags; 1 for a recorded command, -1 for a force channel that lags itself",
    }],
    shape: &[Parameter { name: "lag", unit: "s", min: 1e-5, max: 0.5, what: "time constant T" }],
    columns,
};

fn columns(track: &Track, shape: &[f64; 2]) -> Vec<Vec<f64>> {
    // Of the modelled force: the measured one would carry its own noise to both sides.
    let slow = super::lag(&track.force_model, shape[0], track.raw.dt);
    vec![track.force_model.iter().zip(slow).map(|(f, s)| f - s).collect()]
}
