//! Different gains for push and pull, as of a load cell or a bridge. Against the sign of the force and not of the
//! velocity; on one sine the same as friction that depends on position; told apart with weights both ways.

use super::{Acts, Sensor};
use crate::track::Track;
use friction::effects::Parameter;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "force_gain_asymmetry",
    acts: Acts::OnForce,
    says: "the force channel has another gain for one sign of the force",
    equation: "F = F_model + g·max(F_model, 0)",
    gains: &[Parameter {
        name: "gain",
        unit: "1",
        min: -1.0,
        max: 1.0,
        what: "extra gain for positive force",
    }],
    shape: &[],
    columns,
};

fn columns(track: &Track, _shape: &[f64; 2]) -> Vec<Vec<f64>> {
    vec![track.force_model.iter().map(|f| f.max(0.0)).collect()]
}
