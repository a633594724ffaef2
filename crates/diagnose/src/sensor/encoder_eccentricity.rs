//! A wave on the measured position. Its acceleration grows with v², which tells it from `cogging`, a line of the
//! same height at every speed: three speeds.
//!
//! Here it is sought in the force, for recordings that have a position alone. Where an accelerometer or a tachometer does not
//! go through the encoder, comparing the channels says more ([`crate::witness`]).

use super::{Acts, Sensor};
use crate::signal::derivative;
use crate::track::Track;
use friction::effects::Parameter;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "encoder_eccentricity",
    acts: Acts::OnMotion,
    says: "the encoder disc is eccentric, so the position carries a wave",
    equation: "x = x_true + ε·cos(2πx/λ + φ), F gains m·d²/dt² of it",
    gains: &[
        Parameter {
            name: "cosine",
            unit: "N·s²",
            min: -1e9,
            max: 1e9,
            what: "amplitude of the cosine times the mass",
        },
        Parameter { name: "sine", unit: "N·s²", min: -1e9, max: 1e9, what: "the same for the sine" },
    ],
    shape: &[Parameter {
        name: "wavelength",
        unit: "m",
        min: 1e-6,
        max: 100.0,
        what: "travel per turn of the encoder λ",
    }],
    columns,
};

fn columns(track: &Track, shape: &[f64; 2]) -> Vec<Vec<f64>> {
    let dt = track.raw.dt;
    let wave = |phase: f64| {
        let wave: Vec<f64> =
            track.x.iter().map(|x| (std::f64::consts::TAU * x / shape[0] + phase).cos()).collect();
        derivative(&derivative(&wave, dt), dt)
    };
    vec![wave(0.0), wave(-std::f64::consts::FRAC_PI_2)]
}
