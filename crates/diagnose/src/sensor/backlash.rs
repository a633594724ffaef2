//! Play between drive and load: the load flies on freely while the play is crossed and is caught at its other end.
//! Confused with presliding; told apart by an encoder on the load.
//!
//! The load is simulated behind the measured drive: it keeps its speed inside the play, and takes on the drive's where
//! the play ends (a plastic blow). Where the play ends depends on the position alone, so its noise is kept out first: a
//! load that rests against one side would rattle in it.

use super::{Acts, Sensor};
use crate::signal::LowPass;
use crate::track::Track;
use friction::effects::Parameter;
use identify::dynamics::load_in_play;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "backlash",
    acts: Acts::Behind,
    says: "a play between drive and load: for a stretch the load is out of contact",
    equation: "F = m·a + m_load·(a₂ − a), a₂ = 0 within the play, v₂ = v at its ends",
    gains: &[Parameter {
        name: "mass",
        unit: "kg",
        min: 0.0,
        max: 1e6,
        what: "mass of the load behind the play",
    }],
    shape: &[Parameter { name: "gap", unit: "m", min: 1e-7, max: 1.0, what: "play, from end to end" }],
    columns,
};

fn columns(track: &Track, shape: &[f64; 2]) -> Vec<Vec<f64>> {
    let dt = track.raw.dt;
    let smooth = LowPass::new(0.5 * track.filter.cutoff, dt).apply(&track.raw.position);
    let load = load_in_play(&smooth, shape[0], dt);
    vec![load.iter().zip(&track.a).map(|(load, drive)| load - drive).collect()]
}
