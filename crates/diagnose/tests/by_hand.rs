//! A handle that a hand moves: asperities bend by some hundredths of a millimetre before they slide, and the strokes are of all
//! lengths and speeds.

use diagnose::{Diagnosis, Options, diagnose};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use signals::Recording;
use std::f64::consts::{PI, TAU};

const DT: f64 = 1e-3;
const SECONDS: f64 = 30.0;
const QUANTUM: f64 = 2.6e-6;
const FREQUENCIES: [f64; 6] = [0.19, 0.37, 0.62, 1.1, 1.9, 3.1];
/// Integration steps of a sample.
const FINE: usize = 20;

/// A block of 0.45 kg behind a soft arm whose hand wanders. Friction of 1.3 N is that of bristles of a length, m; a film that a change
/// of speed thins for a while takes off as much as `film`, N·s/m.
fn moved_by_hand(bristle: f64, film: f64, accelerometer: bool, seed: u64) -> Recording {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let phases: [f64; 6] = std::array::from_fn(|_| random.random_range(0.0..TAU));
    let hand = |t: f64| -> f64 {
        let begins = (0.5 - 0.5 * (PI * (t / 1.5).min(1.0)).cos()).powi(2);
        let waves = FREQUENCIES.iter().zip(phases).map(|(f, p)| 0.022 / (0.5 + f) * (TAU * f * t + p).sin());
        begins * waves.sum::<f64>()
    };
    let mut recording = Recording { name: "hand".into(), ..Recording::default() };
    let (mass, level, viscous, h) = (0.45, 1.3, 2.0, DT / FINE as f64);
    let [mut x, mut v, mut arm, mut force, mut z, mut mean] = [0.0_f64; 6];
    let mut accelerations = Vec::new();
    for step in 0..(SECONDS / h) as usize {
        let t = step as f64 * h;
        arm += (hand(t) - arm) * h / 0.012;
        force += (900.0 * (arm - x) - 24.0 * v - force) * h / 0.003;
        z += (v - v.abs() * z / bristle) * h;
        mean += (v.abs() - mean) * h / 0.15;
        let film = film * (mean - v.abs()) * v.signum();
        let a = (force - level * z / bristle - viscous * v - film) / mass;
        if step % FINE == 0 {
            let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
            recording.time.push(t);
            recording.position.push((x / QUANTUM).floor() * QUANTUM);
            recording.force.push(force + 0.03 * noise());
            accelerations.push(a + 0.03 * noise());
        }
        v += a * h;
        x += v * h;
    }
    recording.acceleration = accelerometer.then_some(accelerations);
    recording
}

fn answer(recording: &Recording) -> Diagnosis {
    diagnose(std::slice::from_ref(recording), &[], &Options::default(), &|_, _| ()).expect("accepted")
}

#[test]
fn a_handle_with_an_accelerometer_had_no_presliding() {
    for (bristle, accelerometer) in [(3e-5, true), (4.5e-5, true), (4.5e-5, false)] {
        let d = answer(&moved_by_hand(bristle, 0.0, accelerometer, 7));
        let found = d.missing.iter().find(|m| m.effect == "presliding");
        let x_s = found.map(|m| (m.parameters["x_s"].value, m.parameters["x_s"].std));
        let names: Vec<&str> = d.missing.iter().map(|m| m.effect.as_str()).collect();
        println!(
            "{bristle:e} m, accelerometer {accelerometer}: {names:?}, {x_s:?}, of {:.2}",
            d.judged_share
        );
        assert!(x_s.is_some_and(|(x_s, _)| (x_s / bristle - 1.0).abs() < 0.15));
        assert!(d.judged_share > 0.85);
    }
}

#[test]
fn a_film_beside_bristles_is_no_share_of_the_force() {
    for seed in 1..4 {
        let d = answer(&moved_by_hand(4e-5, 1.5, true, seed));
        let names: Vec<&str> = d.missing.iter().map(|m| m.effect.as_str()).collect();
        println!("{names:?}, {:.4} -> {:.4}", d.baseline.rms_heldout, d.after.rms_heldout);
        assert!(names.contains(&"presliding") && !names.contains(&"load_dependent_friction"));
    }
}
