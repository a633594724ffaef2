//! Free run: the final model driven by the measured force, over short horizons.
//!
//! A mass under friction driven open loop by a measured force drifts without bound: the smallest offset of
//! the force integrates twice. So the run starts anew from the measured state every quarter of a period; the
//! error is that of the position relative to how far the body went within each horizon: 0 is perfect, 1 is a
//! body that never moved.

use crate::library::design_matrix::DesignMatrix;
use crate::preparation::track::Track;
use friction::effects::{EffectKind, MAX_GAINS, MAX_MEMORY, MAX_SHAPE};
use friction::{FreeForm, FreeFormState, Motion};

/// The mechanical model to run.
#[derive(Debug, Clone, Default)]
pub struct Plant {
    /// Mass, kg.
    pub mass: f64,
    /// Coulomb level forward and backward.
    pub coulomb: [f64; 2],
    /// Viscous coefficient forward and backward.
    pub viscous: [f64; 2],
    /// Force effects with gains and shape.
    pub effects: Vec<(EffectKind, [f64; MAX_GAINS], [f64; MAX_SHAPE])>,
    /// Physics without a name.
    pub free: Vec<FreeForm<f64>>,
    /// Per track: what sensor effects add to the recorded force, at every sample.
    pub sensors: Vec<Vec<f64>>,
}

/// Relative position error and the simulated position (first track only); None when it cannot be run.
pub fn run(design: &DesignMatrix, plant: &Plant, frequency: f64) -> Option<(f64, Vec<f64>)> {
    if !(plant.mass.is_finite() && plant.mass > 0.0) {
        return None;
    }
    let (mut error, mut travel) = (0.0, 0.0);
    let mut first = None;
    for (index, track) in design.tracks.iter().enumerate() {
        let horizon = ((0.25 / frequency.max(1e-6)) / track.raw.dt).round().clamp(20.0, 1e6) as usize;
        let simulated = run_track(track, plant, plant.sensors.get(index), horizon);
        for (start, (x, s)) in track.x.chunks(horizon).zip(simulated.chunks(horizon)).enumerate() {
            let _ = start;
            for (x_i, s_i) in x.iter().zip(s) {
                error += (s_i - x_i).powi(2);
                travel += (x_i - x[0]).powi(2);
            }
        }
        first.get_or_insert(simulated);
    }
    let relative = (error / travel).sqrt();
    relative.is_finite().then(|| (relative, first.unwrap_or_default()))
}

fn run_track(track: &Track, plant: &Plant, sensor: Option<&Vec<f64>>, horizon: usize) -> Vec<f64> {
    let dt = track.raw.dt;
    let mut measured = vec![[0.0; MAX_MEMORY]; plant.effects.len()];
    let mut memory = measured.clone();
    let mut free_measured = vec![FreeFormState::default(); plant.free.len()];
    let mut free = free_measured.clone();
    let (mut x, mut v) = (0.0, 0.0);
    let mut out = Vec::with_capacity(track.len());
    for i in 0..track.len() {
        if i % horizon == 0 {
            (x, v) = (track.x[i], track.v[i]);
            memory.clone_from(&measured);
            free.clone_from(&free_measured);
        }
        out.push(x);
        let force = track.f[i] - sensor.map_or(0.0, |s| s[i]);
        let normal = track.normal.as_ref().map(|n| n[i]);
        let motion = |position, displacement, velocity| Motion {
            dt,
            position,
            displacement,
            velocity,
            applied: force,
            mass: 0.0,
            normal,
        };
        let mut extra = 0.0;
        for ((kind, gains, shape), memory) in plant.effects.iter().zip(&mut memory) {
            let unit = kind.unit(shape, memory, &motion(x, v * dt, v));
            extra += unit.iter().zip(gains).map(|(u, g)| u * g).sum::<f64>();
        }
        let moved = motion(x, v * dt, v);
        extra += plant.free.iter().zip(&mut free).map(|(f, state)| f.step(state, &moved)).sum::<f64>();
        let step = if i > 0 { track.x[i] - track.x[i - 1] } else { 0.0 };
        let seen = motion(track.x[i], step, track.v[i]);
        for ((kind, _, shape), memory) in plant.effects.iter().zip(&mut measured) {
            kind.unit(shape, memory, &seen);
        }
        for (form, state) in plant.free.iter().zip(&mut free_measured) {
            form.step(state, &seen);
        }
        let way = usize::from(v < 0.0 || v == 0.0 && force < 0.0);
        let free = v + dt * (force - plant.viscous[way] * v - extra) / plant.mass;
        // Coulomb friction as a stopping force: it may bring the body to rest within the step, not beyond.
        let stop = dt * plant.coulomb[usize::from(free < 0.0)] / plant.mass;
        v = if free.abs() <= stop { 0.0 } else { free - stop * free.signum() };
        x += dt * v;
    }
    out
}
