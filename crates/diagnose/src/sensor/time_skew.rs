//! The force channel and the motion channels are not simultaneous: largest where the force changes fastest. Confused
//! with `actuator_lag` (cosine 0.87-0.94) and with an anti-aliasing filter on one channel; told apart by its phase, which
//! grows linearly with frequency: a move that contains one fast component.
//!
//! The shift is exact, not its first term −τ·dF/dt: at a third of a period that is wrong by half, and the phase is what
//! tells a delay from a lag.

use super::{Acts, Sensor, delayed, true_force};
use crate::track::Track;
use friction::effects::Parameter;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "time_skew",
    acts: Acts::InTime,
    says: "the force was recorded at another moment than the position",
    equation: "F(t) = F_model(t ∓ τ), τ = tau",
    gains: &[
        Parameter {
            name: "behind",
            unit: "1",
            min: 0.0,
            max: super::MOST_SHARE,
            what: "share of the force that is late; 1 but for noise",
        },
        Parameter { name: "ahead", unit: "1", min: 0.0, max: super::MOST_SHARE, what: "share that is early" },
    ],
    shape: &[Parameter {
        name: "tau",
        unit: "s",
        min: 1e-6,
        max: 1.0,
        what: "time lag between force and position",
    }],
    columns,
};

fn columns(track: &Track, shape: &[f64; 2]) -> Vec<Vec<f64>> {
    let dt = track.raw.dt;
    [shape[0], -shape[0]]
        .into_iter()
        .map(|tau| {
            let force = true_force(track, &delayed(&track.f, -tau, dt));
            delayed(&force, tau, dt).iter().zip(&force).map(|(late, now)| late - now).collect()
        })
        .collect()
}
