//! The force channel and the motion channels are not simultaneous: e = −τ·dF/dt, largest where the force changes
//! fastest. Confused with `actuator_lag` (cosine 0.87-0.94) and with an anti-aliasing filter on one channel;
//! told apart by its phase, which grows linearly with frequency: a move that contains one fast component.

use super::Sensor;
use crate::signal::derivative;
use crate::track::Track;
use friction::effects::Parameter;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "time_skew",
    says: "the force was recorded at another moment than the position",
    equation: "F(t) = F_model(t − τ) ≈ F_model − τ·dF/dt",
    gains: &[Parameter {
        name: "tau",
        unit: "s",
        min: -1.0,
        max: 1.0,
        what: "delay of the force behind the position; negative when the position is late",
    }],
    shape: &[],
    columns,
};

fn columns(track: &Track, _shape: &[f64; 2]) -> Vec<Vec<f64>> {
    let rate = derivative(&track.f, track.raw.dt);
    vec![rate.iter().map(|r| -r).collect()]
}
