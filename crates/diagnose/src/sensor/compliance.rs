//! A mass that changes with frequency. On one sine exactly a mass (U = 0); a chirp or a pulse shows it.

use super::Sensor;
use crate::signal::derivative;
use crate::track::Track;
use friction::effects::Parameter;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "compliance",
    says: "drive and load are two masses with a spring between them",
    equation: "F = (m₁ + m₂)·a + (m₁·m₂/k)·d²a/dt²",
    gains: &[Parameter {
        name: "snap",
        unit: "N·s⁴/m",
        min: -1e6,
        max: 1e6,
        what: "m₁·m₂/k; negative for an encoder on the drive side",
    }],
    shape: &[],
    columns,
};

fn columns(track: &Track, _shape: &[f64; 2]) -> Vec<Vec<f64>> {
    let dt = track.raw.dt;
    vec![derivative(&derivative(&track.a, dt), dt)]
}
