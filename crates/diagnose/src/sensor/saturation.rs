//! A limit of the force below what was commanded: only at peak force. Confused with a cubic in F (0.93); an
//! amplitude ladder tells them apart.

use super::{Acts, Sensor};
use crate::track::Track;
use friction::effects::Parameter;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "saturation",
    acts: Acts::OnForce,
    says: "the force stops growing at a limit that the recording does not show",
    equation: "F = F_model − g·(|F_model| − F_max)₊·sgn F",
    gains: &[Parameter {
        name: "share",
        unit: "1",
        min: -2.0,
        max: 0.0,
        what: "minus the share of the excess that is cut; −1 is a hard limit, beyond only by noise",
    }],
    shape: &[Parameter { name: "limit", unit: "N", min: 1e-9, max: 1e9, what: "F_max" }],
    columns,
};

fn columns(track: &Track, shape: &[f64; 2]) -> Vec<Vec<f64>> {
    vec![track.force_model.iter().map(|f| (f.abs() - shape[0]).max(0.0) * f.signum()).collect()]
}
