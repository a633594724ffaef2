//! Play between drive and load: the load flies on freely while the play is crossed and is caught at its other end.
//! Confused with presliding; told apart by an encoder on the load.
//!
//! The load is simulated behind the measured drive: it keeps its speed inside the play, and takes on the drive's where
//! the play ends (a plastic blow). Where the play ends depends on the position alone, so its noise is kept out first: a
//! load that rests against one side would rattle in it.

use super::Sensor;
use crate::signal::LowPass;
use crate::track::Track;
use friction::effects::Parameter;

/// Catalogue entry.
pub const SENSOR: Sensor = Sensor {
    id: "backlash",
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
    let load = carried(&smooth, shape[0], dt);
    vec![load.iter().zip(&track.a).map(|(load, drive)| load - drive).collect()]
}

/// Acceleration of a free body inside a box of length `gap` that moves as `drive`, with plastic blows at its ends.
fn carried(drive: &[f64], gap: f64, dt: f64) -> Vec<f64> {
    let half = 0.5 * gap;
    let (mut x, mut v) = (drive.first().copied().unwrap_or(0.0), 0.0);
    let mut before = x;
    drive
        .iter()
        .map(|&at| {
            let speed = (at - before) / dt;
            before = at;
            let was = v;
            x += v * dt;
            if x > at + half {
                (x, v) = (at + half, f64::min(v, speed));
            } else if x < at - half {
                (x, v) = (at - half, f64::max(v, speed));
            }
            (v - was) / dt
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_flies_on_when_the_drive_turns_back() {
        let (dt, gap) = (1e-4, 0.02);
        // forward at 1 m/s for 0.1 s, then backward: the load crosses the play at 2 m/s against the drive
        let drive: Vec<f64> =
            (0..2000).map(|i| f64::from(i) * dt).map(|t| if t < 0.1 { t } else { 0.2 - t }).collect();
        let a = carried(&drive, gap, dt);
        let blows: Vec<(usize, f64)> =
            a.iter().enumerate().filter(|(_, a)| a.abs() > 1.0).map(|(i, a)| (i, a * dt)).collect();
        println!("{blows:?}");
        // picked up after half the play, carried, caught at the other side
        assert_eq!(blows.len(), 2);
        assert!(blows[0].0.abs_diff(100) < 3 && (blows[0].1 - 1.0).abs() < 1e-6);
        assert!(blows[1].0.abs_diff(1100) < 3 && (blows[1].1 + 2.0).abs() < 1e-6);
    }
}
