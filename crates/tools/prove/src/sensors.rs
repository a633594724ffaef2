//! What the channels make of the history: effects that sit in a sensor or the drive, faults of a recording, noise and
//! quantisation.

use crate::body::Body;
use crate::estimator::estimator;
use crate::hidden::Hidden;
use crate::plant::{FINE, History};
use crate::scale::{NOISE, RATE};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use signals::{Geometry, Recording};
use std::f64::consts::TAU;

/// The bench: what moves, and which channels are recorded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bench {
    /// Half of the stroke, m or rad.
    pub half: f64,
    /// An axis rather than a slide.
    pub rotary: bool,
    /// A velocity channel is recorded.
    pub velocity: bool,
    /// An acceleration channel is recorded.
    pub acceleration: bool,
    /// The load on the contact is recorded.
    pub load: bool,
}

/// A fault of the recording that is not physics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Decoy {
    /// What it is called in the tables.
    pub id: &'static str,
    /// Effects that may be named without being wrong.
    pub allowed: &'static [&'static str],
}

/// Recording faults that look like physics.
pub(crate) const DECOYS: &[Decoy] = &[
    Decoy { id: "hidden_filter", allowed: &["time_skew", "actuator_lag"] },
    Decoy { id: "delay_below_a_sample", allowed: &["time_skew"] },
    Decoy { id: "drifting_zero", allowed: &["offset"] },
    Decoy { id: "lost_samples", allowed: &[] },
    Decoy { id: "velocity_scale", allowed: &[] },
    Decoy { id: "accelerometer_error", allowed: &["accelerometer_error"] },
];

/// Noise-free channels at the rate of the recording, in half strokes.
#[derive(Debug, Clone)]
pub(crate) struct Channels {
    /// Position as the encoder shows it.
    pub y: Vec<f64>,
    /// Velocity as the velocity channel shows it.
    pub w: Vec<f64>,
    /// Force as the force channel shows it.
    pub force: Vec<f64>,
    /// Force beyond the baseline that a reader of these channels meets.
    pub beyond: Vec<f64>,
}

/// The channels of a history.
pub(crate) fn channels(history: &History, body: &Body, hidden: &[Hidden]) -> Channels {
    let n = history.y.len();
    let load = |i: usize| history.force[i * FINE];
    let mut y = history.y.clone();
    let mut w = history.w.clone();
    let mut force: Vec<f64> = (0..n).map(load).collect();
    for effect in hidden {
        let g = effect.size;
        let line = |y: f64| (TAU * y / effect.wavelength() + effect.phase).cos();
        match effect.kind.id {
            "actuator_lag" => force = (0..n).map(|i| history.command[i * FINE]).collect(),
            "time_skew" => force = late(&history.force, g),
            "velocity_lag" => {
                // a first-order estimator
                let keep = estimator(g);
                let mut state = w.first().copied().unwrap_or(0.0);
                for w in &mut w {
                    state = *w + (state - *w) * keep;
                    *w = state;
                }
            }
            "torque_ripple" => force.iter_mut().zip(&history.y).for_each(|(f, y)| *f *= 1.0 + g * line(*y)),
            "force_gain_asymmetry" => force.iter_mut().for_each(|f| *f += g * f.max(0.0)),
            "force_crosstalk" => {
                force.iter_mut().zip(&history.a).for_each(|(f, a)| *f += 0.3 * body.mass * a)
            }
            "saturation" => {
                // of the bench, so that it is the same in its second recording
                let limit = 0.5 * (body.force(60.0, 6.0) - body.force(-60.0, -6.0));
                force.iter_mut().for_each(|f| *f -= g * (f.abs() - limit).max(0.0) * f.signum());
            }
            "encoder_eccentricity" => {
                let wave = |y: &f64| y + g * (TAU * y / 0.8 + effect.phase).cos();
                y = history.y.iter().map(wave).collect();
                w = slope(&y);
            }
            _ => {}
        }
    }
    let shown = |i: usize| if y[i] == history.y[i] { 0.0 } else { 1.0 };
    let bend = slope(&slope(&y.iter().zip(&history.y).map(|(a, b)| a - b).collect::<Vec<_>>()));
    let beyond = (0..n)
        .map(|i| {
            // A channel that shows another motion makes the baseline expect another force.
            let expected =
                shown(i) * body.mass * bend[i] + body.force(0.0, w[i]) - body.force(0.0, history.w[i]);
            history.extra[i] + force[i] - load(i) - expected
        })
        .collect();
    Channels { y, w, force, beyond }
}

/// The fine series `by` seconds late, at every sample.
fn late(fine: &[f64], by: f64) -> Vec<f64> {
    let last = (fine.len() - 1) as f64;
    (0..fine.len() / FINE)
        .map(|i| {
            let at = ((i * FINE) as f64 - by * RATE * FINE as f64).clamp(0.0, last);
            let (low, share) = (at.floor() as usize, at.fract());
            let high = (low + 1).min(fine.len() - 1);
            fine[low] * (1.0 - share) + fine[high] * share
        })
        .collect()
}

/// Central differences at the rate of the recording.
fn slope(series: &[f64]) -> Vec<f64> {
    let n = series.len();
    (0..n)
        .map(|i| {
            let (low, high) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (series[high] - series[low]) * RATE / (high - low).max(1) as f64
        })
        .collect()
}

/// A recording of the channels: noise and quantisation by `seed`, and the fault `decoy`.
pub(crate) fn record(
    bench: &Bench,
    channels: &Channels,
    history: &History,
    decoy: Option<&Decoy>,
    seed: u64,
) -> Recording {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let is = |id: &str| decoy.is_some_and(|d| d.id == id);
    let per = bench.half;
    let n = channels.y.len();
    let mut force = channels.force.clone();
    if is("hidden_filter") {
        let keep = (-TAU * 25.0 / RATE).exp();
        let mut state = force[0];
        for f in &mut force {
            state = *f + (state - *f) * keep;
            *f = state;
        }
    }
    if is("delay_below_a_sample") {
        force = late(&history.force, 0.8 / RATE);
    }
    if is("drifting_zero") {
        force.iter_mut().enumerate().for_each(|(i, f)| *f += 2.0 * NOISE * (i as f64 / n as f64 - 0.5));
    }
    let mut draw = |sigma: f64| -> f64 {
        let z: f64 = StandardNormal.sample(&mut random);
        sigma * z
    };
    let quantise = |x: f64, quantum: f64| (x / quantum).round() * quantum;
    let mut r = Recording {
        geometry: if bench.rotary { Geometry::Rotary } else { Geometry::Linear },
        ..Recording::default()
    };
    let (mut velocity, mut acceleration) = (Vec::new(), Vec::new());
    let gain = if is("velocity_scale") { 1.08 } else { 1.0 };
    for (i, force) in force.into_iter().enumerate() {
        r.time.push(tidy(i as f64 / RATE, 1e-6));
        r.position.push(tidy(quantise(channels.y[i] * per + draw(1e-4 * per), 2.5e-4 * per), 1e-6 * per));
        r.force.push(tidy(quantise(force + draw(NOISE), 0.01), 1e-4));
        velocity.push(tidy(gain * channels.w[i] * per + draw(0.01 * per), 1e-5 * per));
        let scale = if is("accelerometer_error") { 1.15 } else { 1.0 };
        let zero = if is("accelerometer_error") { 3.0 } else { 0.0 };
        acceleration.push(tidy(scale * history.a[i] * per + (zero + draw(3.0)) * per, 1e-4 * per));
    }
    r.velocity = (bench.velocity || is("velocity_scale")).then_some(velocity);
    r.acceleration = (bench.acceleration || is("accelerometer_error")).then_some(acceleration);
    r.normal_force = bench.load.then(|| history.load.iter().map(|l| tidy(l + draw(NOISE), 1e-4)).collect());
    if is("lost_samples") {
        let kept: Vec<usize> = (0..n).filter(|_| random.random::<f64>() > 0.003).collect();
        for series in [Some(&mut r.time), Some(&mut r.position), Some(&mut r.force)]
            .into_iter()
            .chain([r.velocity.as_mut(), r.acceleration.as_mut(), r.normal_force.as_mut()])
            .flatten()
        {
            *series = kept.iter().map(|&i| series[i]).collect();
        }
    }
    r
}

/// The noise-free truth of the channels, for a judge: position, velocity, acceleration and force; as the reference,
/// where the body really was.
pub(crate) fn truth(bench: &Bench, channels: &Channels, history: &History) -> Recording {
    let per = bench.half;
    let scaled = |series: &[f64]| -> Vec<f64> { series.iter().map(|x| x * per).collect() };
    Recording {
        geometry: if bench.rotary { Geometry::Rotary } else { Geometry::Linear },
        time: (0..channels.y.len()).map(|i| i as f64 / RATE).collect(),
        position: scaled(&channels.y),
        force: channels.force.clone(),
        velocity: Some(scaled(&channels.w)),
        acceleration: Some(scaled(&history.a)),
        normal_force: Some(history.load.clone()),
        reference: Some(scaled(&history.y)),
        ..Recording::default()
    }
}

/// A number without digits that mean nothing, so that a file stays small.
fn tidy(x: f64, step: f64) -> f64 {
    let places = (-step.log10()).ceil().clamp(0.0, 15.0) as i32;
    let power = 10f64.powi(places);
    (x * power).round() / power
}
