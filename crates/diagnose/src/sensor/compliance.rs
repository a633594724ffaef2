//! Drive and load are two bodies on a spring: the load follows the drive through a resonance, so that the mass the
//! drive feels rises with frequency. On one sine exactly a mass (U = 0); a chirp or a pulse shows it.
//!
//! The load's acceleration a₂ is that of the encoder's body behind the exact resonance, and not the first term of its
//! series, a fourth derivative of the position: near the resonance the series is wrong, and above it the load smooths
//! the encoder's noise, which the series differentiates. The encoder is taken to sit on the drive.

use super::{Acts, Sensor};
use crate::track::Track;
use friction::effects::Parameter;
use identify::dynamics::load_on_spring;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "compliance",
    acts: Acts::Behind,
    says: "drive and load are two masses with a spring between them",
    equation: "F = m·a + m_load·(a₂ − a), a₂ = (2ζωs + ω²)/(s² + 2ζωs + ω²)·a, ω = 2π·frequency",
    gains: &[Parameter { name: "mass", unit: "kg", min: 0.0, max: 1e6, what: "mass of the load" }],
    shape: &[
        Parameter {
            name: "frequency",
            unit: "Hz",
            min: 0.1,
            max: 1e4,
            what: "at which the load would swing with the drive held",
        },
        Parameter { name: "damping", unit: "1", min: 0.02, max: 0.6, what: "damping ratio ζ of that" },
    ],
    columns,
};

fn columns(track: &Track, shape: &[f64; 2]) -> Vec<Vec<f64>> {
    let follows = load_on_spring(&track.a, shape[0], shape[1], track.raw.dt);
    vec![follows.iter().zip(&track.a).map(|(load, drive)| load - drive).collect()]
}
