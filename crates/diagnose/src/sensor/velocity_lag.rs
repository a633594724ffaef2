//! A velocity estimator's lag: a spike of twice the Coulomb force at every reversal, as long as the lag. On one
//! sine the same as `frictional_lag`; told apart by moves with dwells, or by recomputing v from x.

use super::{Acts, Sensor};
use crate::track::Track;
use friction::effects::Parameter;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "velocity_lag",
    acts: Acts::OnMotion,
    says: "the velocity channel lags, so friction seems to reverse late",
    equation: "s·C with s = sgn v(t − T) instead of sgn v(t)",
    gains: &[Parameter {
        name: "force",
        unit: "N",
        min: -1e6,
        max: 1e6,
        what: "Coulomb level seen through the lag",
    }],
    shape: &[Parameter { name: "lag", unit: "s", min: 1e-4, max: 0.2, what: "lag of the velocity" }],
    columns,
};

fn columns(track: &Track, shape: &[f64; 2]) -> Vec<Vec<f64>> {
    let late = super::delayed(&track.sign, shape[0], track.raw.dt);
    vec![late.iter().zip(&track.sign).map(|(l, s)| l - s).collect()]
}
