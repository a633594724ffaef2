//! Forces without a name: over two coordinates, over one that is derived, over a memory, much shorter than the stroke.

mod plant;

use diagnose::{Diagnosis, Options, diagnose};
use plant::{Case, record};
use signals::Recording;
use std::f64::consts::TAU;
use untested::draws;

/// The largest magnitude.
fn largest(series: &[f64]) -> f64 {
    series.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// A recording of the plant, its velocity and its acceleration, each from the position.
fn sliding(seed: u64) -> (Recording, Vec<f64>, Vec<f64>) {
    let recording = record(&Case { seed, seconds: 16.0, ..Case::default() }).0;
    let x = &recording.position;
    let inside = |i: usize| i.clamp(15, x.len() - 16);
    let first = |i: usize| (x[i + 10] - x[i - 10]) / 0.02;
    let second = |i: usize| (x[i + 15] - 2.0 * x[i] + x[i - 15]) / 0.015f64.powi(2);
    let velocity = (0..x.len()).map(|i| first(inside(i))).collect();
    let acceleration = (0..x.len()).map(|i| second(inside(i))).collect();
    (recording, velocity, acceleration)
}

/// What is said of a recording to which this force is added.
fn told(mut recording: Recording, added: impl Fn(usize) -> f64) -> Diagnosis {
    recording.force.iter_mut().enumerate().for_each(|(i, f)| *f += added(i));
    let d = diagnose(&[recording], &[], &Options::default(), &|_, _| ()).expect("accepted");
    for m in &d.missing {
        println!("{}: {}", m.effect, m.says);
    }
    println!(
        "{:.4} -> {:.4} N, floor {:.4} N",
        d.baseline.rms_heldout, d.after.rms_heldout, d.noise_floor.rms
    );
    d
}

/// The answer was *friction over the speed*, and on another motion that model was worse than none: a map with all values free
/// predicted nothing where it was not fitted.
#[test]
fn a_force_over_position_and_velocity_was_friction_over_the_speed() {
    for seed in draws(1, 4) {
        let (recording, velocity, _) = sliding(420 + seed);
        let x = recording.position.clone();
        let (stroke, speed) = (largest(&x), largest(&velocity));
        let d = told(recording, |i| {
            let (y, u) = (x[i] / stroke, velocity[i] / speed);
            0.09 * (TAU * (0.3 * y + 0.8 * u) + 0.4).cos() + 0.07 * (TAU * (0.7 * y - 0.5 * u)).sin()
        });
        assert!(d.missing[0].says.contains("position and velocity together"));
        assert!(d.after.rms_heldout < 0.7 * d.baseline.rms_heldout);
    }
}

/// The answer was *depends on something that is not in the recording*: a curve over the velocity explained a little of it, and a
/// derived acceleration was tried only where nothing else explained anything.
#[test]
fn a_force_over_acceleration_was_said_to_be_over_nothing_in_the_recording() {
    for seed in draws(1, 4) {
        let (full, _, acceleration) = sliding(440 + seed);
        let most = largest(&acceleration);
        let recording = Recording { velocity: None, acceleration: None, ..full };
        let d = told(recording, |i| 0.15 * (TAU * 0.9 * acceleration[i] / most + 0.6).cos());
        assert!(d.missing[0].says.contains("over acceleration"));
        assert!(d.after.rms_heldout < 0.6 * d.baseline.rms_heldout);
    }
}

/// The answer was a torque ripple and a hard stop, and on another motion that model was worse than none.
#[test]
fn an_inertia_that_depends_on_the_place_was_a_torque_ripple() {
    for seed in draws(1, 4) {
        let (recording, _, acceleration) = sliding(460 + seed);
        let x = recording.position.clone();
        let most = largest(&x) * largest(&acceleration);
        let d = told(recording, |i| 0.9 * x[i] * acceleration[i] / most);
        assert!(d.missing[0].says.contains("position and acceleration together"));
        assert!(d.after.rms_heldout < 0.6 * d.baseline.rms_heldout);
    }
}

/// The answer was load-dependent friction.
#[test]
fn a_spring_that_relaxes_was_friction() {
    for seed in draws(1, 4) {
        let (recording, velocity, _) = sliding(480 + seed);
        let mut moved = vec![0.0; velocity.len()];
        for i in 1..moved.len() {
            moved[i] = moved[i - 1] * (1.0 - 1e-3 / 0.35) + 1e-3 * velocity[i];
        }
        let most = largest(&moved);
        let d = told(recording, |i| 0.4 * moved[i] / most);
        assert!(d.missing[0].says.contains("over the displacement in the last moments"));
        let curve = d.missing[0].free_form.as_ref().expect("a curve");
        let memory = curve.curve.memory_s.expect("a memory");
        assert!((0.2..0.6).contains(&memory), "{memory} s for 0.35 s");
        assert!(curve.looks_like.as_ref().is_some_and(|l| l.formula == "moved"));
        assert!(d.after.rms_heldout < 0.6 * d.baseline.rms_heldout);
    }
}

/// The answer was *depends on something that is not in the recording*: 22 knots are too few for ten waves.
#[test]
fn a_ripple_that_grows_along_the_stroke_was_over_nothing_in_the_recording() {
    for seed in draws(1, 4) {
        let (recording, ..) = sliding(500 + seed);
        let x = recording.position.clone();
        let stroke = largest(&x);
        let d = told(recording, |i| 0.25 * x[i] / stroke * (5.0 * TAU * x[i] / stroke).sin());
        assert!(d.missing.iter().any(|m| m.says.starts_with("a force over position, from")));
        assert!(d.after.rms_heldout < 1.4 * d.noise_floor.rms);
    }
}

/// The answer was *depends on something that is not in the recording*: held out over half a period, no curve over time is known.
#[test]
fn a_viscous_coefficient_that_swings_was_over_nothing_in_the_recording() {
    for seed in draws(1, 4) {
        let (recording, velocity, _) = sliding(520 + seed);
        let (time, most) = (recording.time.clone(), largest(&velocity));
        let d = told(recording, |i| 0.4 * velocity[i] / most * (TAU * time[i] / 4.2 + 0.7).sin());
        assert!(d.missing[0].says.starts_with("a viscous coefficient over time"));
        assert!(d.after.rms_heldout < 0.6 * d.baseline.rms_heldout);
    }
}
