//! A joint that a servo drive moves from place to place and lets rest there, recorded by its encoder and its torque alone:
//! asperities bend over some counts of the encoder before they slide.

use diagnose::{Diagnosis, Options, diagnose};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use signals::{Geometry, Recording};
use std::f64::consts::TAU;

/// Of the integration, s.
const STEP: f64 = 5e-5;
const SECONDS: f64 = 30.0;
/// Of the encoder, rad.
const COUNT: f64 = TAU / 65_536.0;

/// The joint: inertia, kg·m², friction and what it has more at rest, N·m, viscous, N·m·s/rad, length of the bristles, rad, weight,
/// N·m.
struct Joint {
    inertia: f64,
    friction: f64,
    at_rest: f64,
    viscous: f64,
    bristle: f64,
    weight: f64,
}

impl Joint {
    fn any(random: &mut ChaCha8Rng) -> Self {
        let mut within = |low: f64, high: f64| random.random_range(low..high);
        Self {
            inertia: within(0.02, 0.08),
            friction: within(0.25, 0.6),
            viscous: within(0.05, 0.25),
            bristle: within(2e-4, 8e-4),
            at_rest: 0.0,
            weight: 0.0,
        }
    }
}

/// What is recorded, one of `every` steps, while a drive with a controller of position, velocity and integral takes it through
/// random moves.
fn moved(joint: &Joint, every: usize, random: &mut ChaCha8Rng) -> Recording {
    let h = STEP;
    let [mut x, mut v, mut z, mut torque, mut sum] = [0.0_f64; 5];
    let [mut from, mut to, mut begins, mut takes, mut rests] = [0.0_f64, 0.0, 0.0, 0.01, 0.0];
    let mut wanted = 0.0;
    let mut recording =
        Recording { name: "servo".into(), geometry: Geometry::Rotary, ..Recording::default() };
    for step in 0..(SECONDS / h) as usize {
        let t = step as f64 * h;
        if t >= begins + takes + rests {
            (from, to, begins) = (to, random.random_range(-2.6..2.6), t);
            takes = 1.9 * (to - from).abs() / 0.3 * random.random_range(-2.8..0.0_f64).exp() + 0.15;
            rests = random.random_range(-0.6..0.6_f64).max(0.0);
        }
        let s = ((t - begins) / takes).min(1.0);
        let before =
            std::mem::replace(&mut wanted, from + (to - from) * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s));
        let error = wanted - x;
        sum += error * h;
        let asked = 60.0 * error + 1.8 * ((wanted - before) / h - v) + 40.0 * sum;
        torque += (asked.clamp(-12.0, 12.0) - torque) * h / 0.002;
        let level = joint.friction + joint.at_rest * (-v.abs() / 0.12).exp();
        let stiffness = level / joint.bristle;
        z += (v - v.abs() * z / joint.bristle) * h;
        if step % every == 0 {
            let noise: f64 = StandardNormal.sample(random);
            recording.time.push(t);
            recording.position.push((x / COUNT).floor() * COUNT);
            recording.force.push(torque + 0.02 * noise);
        }
        let weight = joint.weight * (x + 0.4).sin();
        v += (torque - stiffness * z - joint.viscous * v - weight) / joint.inertia * h;
        x += v * h;
    }
    recording
}

fn answer(recording: &Recording) -> Diagnosis {
    diagnose(std::slice::from_ref(recording), &[], &Options::default(), &|_, _| ()).expect("accepted")
}

/// Lengths below twenty times the position noise were not tried, so presliding ended on that bound and was withdrawn. The inertia of a
/// joint that mostly rests was underestimated, and the filter let the noise of the acceleration through.
#[test]
fn a_servo_that_rests_between_moves_had_no_presliding() {
    let mut found = 0;
    for seed in 1..7 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let joint = Joint::any(&mut random);
        let d = answer(&moved(&joint, 40, &mut random));
        let names: Vec<&str> = d.missing.iter().map(|m| m.effect.as_str()).collect();
        let x_s = d.missing.iter().find(|m| m.effect == "presliding").map(|m| m.parameters["x_s"].value);
        println!(
            "seed {seed}: {names:?}, {x_s:?} of {:.2e} rad, {:.4} of {:.4} N·m, {:.1} Hz",
            joint.bristle, d.after.rms_heldout, d.noise_floor.rms, d.cutoff_hz
        );
        assert!(names.iter().all(|name| *name == "presliding"));
        assert!(x_s.is_none_or(|x_s| (x_s / joint.bristle - 1.0).abs() < 0.15));
        assert!(d.after.rms_heldout < 1.2 * d.noise_floor.rms && d.noise_floor.rms < 0.01);
        found += names.len();
    }
    assert!(found >= 5, "{found} of 6");
}

/// A curve over the position gains nearly as much as the weight does, and with it the friction at rest, several floors, was given up.
#[test]
fn a_weight_hid_what_stands_beside_it() {
    for seed in [8, 11, 12] {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let joint = Joint { at_rest: 0.03, weight: 0.36, ..Joint::any(&mut random) };
        let d = answer(&moved(&joint, 100, &mut random));
        let names: Vec<&str> = d.missing.iter().map(|m| m.effect.as_str()).collect();
        println!("seed {seed}: {names:?}, {:.4} of {:.4} N·m", d.after.rms_heldout, d.noise_floor.rms);
        assert!(names.contains(&"gravity") && !names.contains(&"unnamed"));
        assert!(d.after.rms_heldout < 1.3 * d.noise_floor.rms);
    }
}
