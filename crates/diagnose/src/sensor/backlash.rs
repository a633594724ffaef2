//! Play between drive and load: −m·a while the play is crossed after a force reversal. Confused with presliding;
//! told apart by an encoder on the load.

use super::Sensor;
use crate::track::Track;
use friction::effects::Parameter;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "backlash",
    says: "after the force reverses, the load is out of contact for a stretch",
    equation: "m_load absent while the distance since a force reversal is below the gap",
    gains: &[Parameter {
        name: "mass",
        unit: "kg",
        min: -1e6,
        max: 1e6,
        what: "mass that is out of contact; negative of the load",
    }],
    shape: &[Parameter { name: "gap", unit: "m", min: 1e-7, max: 1.0, what: "play" }],
    columns,
};

fn columns(track: &Track, shape: &[f64; 2]) -> Vec<Vec<f64>> {
    let mut travelled = f64::INFINITY;
    let mut lost = vec![0.0; track.len()];
    for (i, lost) in lost.iter_mut().enumerate().skip(1) {
        if track.force_model[i] * track.force_model[i - 1] < 0.0 {
            travelled = 0.0;
        } else {
            travelled += (track.x[i] - track.x[i - 1]).abs();
        }
        if travelled < shape[0] {
            *lost = track.a[i];
        }
    }
    vec![lost]
}
