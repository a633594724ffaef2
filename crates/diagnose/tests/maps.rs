//! Forces over two coordinates, and over one that is derived.

mod plant;

use diagnose::{Options, diagnose};
use plant::{Case, record};
use signals::Recording;
use std::f64::consts::TAU;
use untested::draws;

/// The largest magnitude.
fn largest(series: &[f64]) -> f64 {
    series.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// The answer was *friction over the speed*, and on another motion that model was worse than none: a map with all values free
/// predicted nothing where it was not fitted.
#[test]
fn a_force_over_position_and_velocity_was_friction_over_the_speed() {
    for seed in draws(1, 4) {
        let mut recording = record(&Case { seed: 420 + seed, seconds: 16.0, ..Case::default() }).0;
        let n = recording.position.len();
        let change = |i: usize| (recording.position[i + 10] - recording.position[i - 10]) / 0.02;
        let velocity: Vec<f64> = (0..n).map(|i| change(i.clamp(10, n - 11))).collect();
        let (stroke, speed) = (largest(&recording.position), largest(&velocity));
        for (i, f) in recording.force.iter_mut().enumerate() {
            let (y, u) = (recording.position[i] / stroke, velocity[i] / speed);
            *f += 0.09 * (TAU * (0.3 * y + 0.8 * u) + 0.4).cos() + 0.07 * (TAU * (0.7 * y - 0.5 * u)).sin();
        }
        let d = diagnose(&[recording], &[], &Options::default(), &|_, _| ()).expect("accepted");
        let says = d.missing.first().map_or("", |m| m.says.as_str());
        println!("{says}: {:.4} -> {:.4} N", d.baseline.rms_heldout, d.after.rms_heldout);
        assert!(says.contains("position and velocity together"));
        assert!(d.after.rms_heldout < 0.7 * d.baseline.rms_heldout);
    }
}

/// The answer was *depends on something that is not in the recording*: a curve over the velocity explained a little of it, and a
/// derived acceleration was tried only where nothing else explained anything.
#[test]
fn a_force_over_acceleration_was_said_to_be_over_nothing_in_the_recording() {
    for seed in draws(1, 4) {
        let full = record(&Case { seed: 440 + seed, seconds: 16.0, ..Case::default() }).0;
        let n = full.position.len();
        let second = |i: usize| {
            (full.position[i + 15] - 2.0 * full.position[i] + full.position[i - 15]) / 0.015f64.powi(2)
        };
        let acceleration: Vec<f64> = (0..n).map(|i| second(i.clamp(15, n - 16))).collect();
        let most = largest(&acceleration);
        let force = full.force.iter().zip(&acceleration);
        let recording = Recording {
            force: force.map(|(f, a)| f + 0.15 * (TAU * 0.9 * a / most + 0.6).cos()).collect(),
            velocity: None,
            acceleration: None,
            ..full.clone()
        };
        let d = diagnose(&[recording], &[], &Options::default(), &|_, _| ()).expect("accepted");
        let says = d.missing.first().map_or("", |m| m.says.as_str());
        println!("{says}: {:.4} -> {:.4} N", d.baseline.rms_heldout, d.after.rms_heldout);
        assert!(says.contains("over acceleration"));
        assert!(d.after.rms_heldout < 0.6 * d.baseline.rms_heldout);
    }
}
