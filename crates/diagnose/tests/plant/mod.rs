//! A slide that owes nothing to the crate under test: its own equations, event-driven sticking, its own
//! integrator at 50 kHz, a field of elasto-plastic bristles instead of a differential law for presliding.
#![allow(dead_code)]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use signals::Recording;
use std::f64::consts::TAU;

/// What is hidden in the plant; `size` is a force in newtons unless said otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hidden {
    Nothing,
    Stribeck {
        size: f64,
        speed: f64,
    },
    Sublinear {
        size: f64,
        speed: f64,
    },
    Quadratic {
        size: f64,
    },
    Spring {
        size: f64,
    },
    Cubic {
        size: f64,
    },
    Cogging {
        size: f64,
        wavelength: f64,
    },
    PeriodicFriction {
        size: f64,
        wavelength: f64,
    },
    PositionFriction {
        size: f64,
    },
    LoadShare {
        size: f64,
    },
    Drift {
        size: f64,
        settle: f64,
    },
    Stop {
        size: f64,
    },
    Bristles {
        size: f64,
        reach: f64,
    },
    /// `size` in seconds.
    Skew {
        size: f64,
    },
    /// It acts on the body, which it shakes.
    Hum {
        size: f64,
        frequency: f64,
    },
}

#[derive(Debug, Clone, Copy)]
pub enum Motion {
    Sine,
    Multisine,
    Triangle,
    Chirp,
}

#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub mass: f64,
    pub coulomb: (f64, f64),
    pub viscous: (f64, f64),
    pub hidden: [Hidden; 2],
    pub motion: Motion,
    pub seconds: f64,
    pub noise_force: f64,
    pub noise_position: f64,
    pub quantum: f64,
    /// Noise of an accelerometer, m/s²; None where there is none.
    pub accelerometer: Option<f64>,
    /// Time constant of its low-pass, s.
    pub accelerometer_lag: f64,
    pub seed: u64,
}

pub const STROKE: f64 = 0.010;

impl Default for Case {
    fn default() -> Self {
        Self {
            mass: 0.42,
            coulomb: (1.75, 1.6),
            viscous: (4.0, 5.0),
            hidden: [Hidden::Nothing; 2],
            motion: Motion::Multisine,
            seconds: 16.0,
            noise_force: 0.062,
            noise_position: 1e-6,
            quantum: 2.57e-6,
            accelerometer: None,
            accelerometer_lag: 0.0,
            seed: 1,
        }
    }
}

fn target(motion: Motion, t: f64) -> f64 {
    match motion {
        Motion::Sine => STROKE * (TAU * 2.0 * t).sin(),
        Motion::Multisine => {
            STROKE
                * (0.55 * (TAU * 1.0 * t).sin()
                    + 0.3 * (TAU * 2.3 * t + 1.0).sin()
                    + 0.25 * (TAU * 4.7 * t + 2.0).sin())
        }
        Motion::Triangle => {
            let phase = (1.0 * t).fract();
            STROKE * (4.0 * (phase - 0.5).abs() - 1.0)
        }
        Motion::Chirp => {
            let rate = 0.4 + 0.25 * t;
            STROKE * (TAU * (0.4 + 0.125 * t) * t).sin() / rate.max(1.0).sqrt()
        }
    }
}

struct Bristle {
    reach: f64,
    bend: f64,
}

/// The force of everything hidden that acts against positive motion while sliding in direction `s`.
fn hidden_force(h: &Hidden, x: f64, v: f64, s: f64, t: f64, applied: f64) -> f64 {
    match *h {
        Hidden::Stribeck { size, speed } => s * size * (-(v / speed).powi(2)).exp(),
        Hidden::Sublinear { size, speed } => s * size * (1.0 - (-(v.abs() / speed)).exp()),
        Hidden::Quadratic { size } => size * v * v.abs() / 0.01,
        Hidden::Spring { size } => size * x / STROKE,
        Hidden::Cubic { size } => size * (x / STROKE).powi(3),
        Hidden::Cogging { size, wavelength } => size * (TAU * x / wavelength + 0.7).cos(),
        Hidden::PeriodicFriction { size, wavelength } => s * size * (TAU * x / wavelength + 0.7).cos(),
        Hidden::PositionFriction { size } => s * size * x / STROKE,
        Hidden::LoadShare { size } => s * size * applied.abs() / 3.0,
        Hidden::Drift { size, settle } => s * size * (-t / settle).exp(),
        Hidden::Hum { size, frequency } => size * (TAU * frequency * t + 0.4).sin(),
        Hidden::Stop { size } => size * ((x - 0.6 * STROKE) / (0.4 * STROKE)).max(0.0),
        _ => 0.0,
    }
}

/// Simulates and records at 1 kHz. Returns the recording and the noise-free force of what is hidden.
pub fn record(case: &Case) -> (Recording, Vec<f64>) {
    let mut random = ChaCha8Rng::seed_from_u64(case.seed);
    let sub = 50;
    let h = 1e-3 / f64::from(sub);
    let warm_up = 1.0;
    let (mut x, mut v) = (target(case.motion, 0.0), 0.0);
    let mut stuck = false;
    let mut bristles: Vec<Bristle> = Vec::new();
    let mut bristle_size = 0.0;
    for hidden in &case.hidden {
        if let Hidden::Bristles { size, reach } = *hidden {
            bristle_size = size;
            bristles = (0..30)
                .map(|i| Bristle { reach: reach * 2.0 * (f64::from(i) + 0.5) / 30.0, bend: 0.0 })
                .collect();
        }
    }
    let mut skew = 0.0;
    for hidden in &case.hidden {
        if let Hidden::Skew { size } = *hidden {
            skew = size;
        }
    }
    let ticks = ((case.seconds + warm_up) * 1000.0) as usize + 1;
    let mut series = Vec::with_capacity(ticks * 5);
    let mut truth = Vec::new();
    let (mut times, mut positions, mut accelerations) = (Vec::new(), Vec::new(), Vec::new());
    // The body's force is kept five times a tick, so that a skewed force channel can be read between samples.
    for tick in 0..ticks {
        let before = v;
        for k in 0..sub {
            let t = tick as f64 * 1e-3 + f64::from(k) * h;
            let applied = 6000.0 * (target(case.motion, t) - x)
                + 60.0 * ((target(case.motion, t + 5e-4) - target(case.motion, t - 5e-4)) / 1e-3 - v);
            let (positive, negative) = case.coulomb;
            let s_motion = if stuck { applied.signum() } else { v.signum() };
            let extra: f64 =
                case.hidden.iter().map(|e| hidden_force(e, x, v, s_motion, t - warm_up, applied)).sum();
            let bristle_force: f64 = bristles.iter().map(|b| b.bend / b.reach).sum::<f64>()
                / bristles.len().max(1) as f64
                * bristle_size;
            let level = if s_motion > 0.0 { positive } else { negative };
            let drag = if v > 0.0 { case.viscous.0 * v } else { case.viscous.1 * v };
            let friction;
            if stuck {
                // The odd part of what is hidden adds to what holds the body; the rest is a load on it.
                let odd: f64 = case
                    .hidden
                    .iter()
                    .map(|e| {
                        0.5 * (hidden_force(e, x, 0.0, s_motion, t - warm_up, applied)
                            - hidden_force(e, x, 0.0, -s_motion, t - warm_up, applied))
                    })
                    .sum();
                let even = extra - odd;
                let load = applied - even - bristle_force;
                let level = if load > 0.0 { positive } else { negative } + odd.abs();
                if load.abs() > level {
                    stuck = false;
                    v = (load - load.signum() * level) / case.mass * h;
                }
                friction = applied;
                if k % 10 == 0 {
                    series.push(friction);
                }
                if k == 0 {
                    truth.push(extra);
                }
            } else {
                let total = s_motion * level + drag + extra + bristle_force;
                let a = (applied - total) / case.mass;
                if k % 10 == 0 {
                    // The load cell sees what accelerates the block and what rubs on it.
                    series.push(applied);
                }
                if k == 0 {
                    truth.push(extra + bristle_force);
                }
                let next = v + a * h;
                if next * v < 0.0 && v != 0.0 {
                    v = 0.0;
                    stuck = true;
                } else {
                    v = next;
                }
            }
            if k == 0 {
                times.push(t);
                positions.push(x);
            }
            for b in &mut bristles {
                b.bend = (b.bend + v * h).clamp(-b.reach, b.reach);
            }
            x += v * h;
        }
        // over the half tick to either side, as a converter that averages has it
        accelerations.push((v - before) / 1e-3);
    }
    let lag = |shown: &mut f64, [before, after]: [f64; 2]| {
        let acts = 0.5 * (before + after);
        let share =
            if case.accelerometer_lag > 0.0 { -(-1e-3 / case.accelerometer_lag).exp_m1() } else { 1.0 };
        *shown += share * (acts - *shown);
        Some(*shown)
    };
    let pairs = accelerations.windows(2).map(|w| [w[0], w[1]]);
    let shown: Vec<f64> = std::iter::once(0.0).chain(pairs.scan(0.0, lag)).collect();
    let force_noise = Normal::new(0.0, case.noise_force.max(1e-300)).unwrap();
    let position_noise = Normal::new(0.0, case.noise_position.max(1e-300)).unwrap();
    let mut recording = Recording { name: format!("plant {}", case.seed), ..Recording::default() };
    let first = (warm_up * 1000.0) as usize;
    for i in first..times.len() - 10 {
        let at = i as f64 * 5.0 - skew * 5000.0;
        let (low, share) = (at.floor() as usize, at.fract());
        let force = series[low] * (1.0 - share) + series[low + 1] * share;
        recording.time.push((times[i] - warm_up).max(0.0));
        let noisy = positions[i] + position_noise.sample(&mut random);
        recording.position.push(if case.quantum > 0.0 {
            (noisy / case.quantum).round() * case.quantum
        } else {
            noisy
        });
        recording.force.push(force + force_noise.sample(&mut random));
    }
    // a stream of its own: what is drawn for the other channels does not depend on it
    let mut random = ChaCha8Rng::seed_from_u64(case.seed ^ 0xacce);
    recording.acceleration = case.accelerometer.map(|noise| {
        let noise = Normal::new(0.0, noise.max(1e-300)).unwrap();
        (first..times.len() - 10).map(|i| shown[i] + noise.sample(&mut random)).collect()
    });
    let truth = truth[first..times.len() - 10].to_vec();
    (recording, truth)
}
