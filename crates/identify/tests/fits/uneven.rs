//! Recordings on uneven clocks: what a clock does to an identification, over seeds.

use identify::{KarnoppOptions, Preprocess, identify_karnopp, prepare};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use signals::Recording;
use std::f64::consts::TAU;

#[derive(Debug, Clone, Copy)]
enum Clock {
    Even,
    /// A loop without a timer: never early, often a little late.
    Late,
    /// A logger in milliseconds that sometimes waits.
    Waits,
}

impl Clock {
    /// The next step, in periods.
    fn step(self, random: &mut ChaCha8Rng) -> f64 {
        let late: f64 = StandardNormal.sample(random);
        let draw: f64 = random.random();
        match self {
            Self::Even => 1.0,
            Self::Late => 0.98 + 0.03 * late.abs(),
            Self::Waits => {
                [(0.87, 1.0), (0.97, 1.1), (0.985, 1.4)].iter().find(|(p, _)| draw < *p).map_or(1.7, |s| s.1)
            }
        }
    }
}

const TRUTH: [(&str, f64); 5] =
    [("mass", 2.0), ("coulomb_p", 1.5), ("coulomb_n", 1.5), ("viscous_p", 5.0), ("viscous_n", 5.0)];

fn recording(clock: Clock, dt: f64, quantum: f64, seed: u64) -> Recording {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut r = Recording { name: format!("{clock:?} {seed}"), ..Recording::default() };
    let mut t = 0.0;
    for _ in 0..3000 {
        t += dt * clock.step(&mut random);
        let tones = [(0.02, TAU * 0.5, 0.0), (0.008, TAU * 1.3, 1.0)];
        let of = |f: &dyn Fn(f64, f64, f64) -> f64| {
            tones.iter().map(|(a, w, p)| f(*a, *w, w * t + p)).sum::<f64>()
        };
        let (x, v, a) =
            (of(&|a, _, p| a * p.sin()), of(&|a, w, p| a * w * p.cos()), of(&|a, w, p| -a * w * w * p.sin()));
        let noise: [f64; 2] = [StandardNormal.sample(&mut random), StandardNormal.sample(&mut random)];
        r.time.push(t);
        r.position.push((x / quantum + 0.3 * noise[0]).round() * quantum);
        r.force.push(2.0 * a + 1.5 * v.signum() + 5.0 * v + 0.02 * noise[1]);
    }
    r
}

/// Straight lines to an even grid made motion slower (the mass 0.1 % too large, two standard errors) and noise smaller (a
/// filter wider by a quarter, and residuals by three quarters, where the encoder is coarse).
#[test]
fn standard_errors_hold_on_uneven_clocks() {
    const SEEDS: u64 = 20;
    for (dt, quantum) in [(0.01, 1e-6), (0.005, 1e-4)] {
        let mut even = f64::NAN;
        for clock in [Clock::Even, Clock::Late, Clock::Waits] {
            let found: Vec<_> = (0..SEEDS)
                .map(|seed| {
                    let signals =
                        prepare(&recording(clock, dt, quantum, seed), &Preprocess::default()).unwrap();
                    identify_karnopp(&signals, &KarnoppOptions::default()).unwrap()
                })
                .collect();
            let mean = |f: &dyn Fn(&identify::Identification) -> f64| {
                found.iter().map(f).sum::<f64>() / SEEDS as f64
            };
            let residual = mean(&|found| found.relative_error);
            if matches!(clock, Clock::Even) {
                even = residual;
            }
            print!("{dt} s, {quantum:.0e} m, {clock:?}: relative error {:.2} %;", 100.0 * residual);
            for (name, truth) in TRUTH {
                let off = mean(&|found| found.parameters[name].value - truth);
                let z =
                    mean(&|f| ((f.parameters[name].value - truth) / f.parameters[name].std).powi(2)).sqrt();
                print!(" {name} {off:+.4} ({z:.2} standard errors)");
                assert!((0.5..1.6).contains(&z), "{clock:?}, {name}: {z} standard errors");
            }
            println!();
            assert!(residual < 1.15 * even, "{clock:?}: {residual}, {even} on an even clock");
        }
    }
}
