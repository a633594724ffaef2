//! Recordings whose friction is known, a known number of just noticeable differences apart.

use compare::{MARGIN, Measured, Verdict, compare};
use signals::Recording;

/// A block of 0.4 kg with friction `level` N and 2 N·s/m, moved by a sine; its own formula, no crate's.
fn recording(level: f64, amplitude: f64, frequency: f64, sign: f64) -> Measured {
    let turn = std::f64::consts::TAU * frequency;
    let mut recording = Recording { name: format!("{level} N at {frequency} Hz"), ..Recording::default() };
    let mut noise = 1_u64;
    for i in 0..20_000 {
        let t = f64::from(i) * 1e-3;
        let (x, v) = (amplitude * (turn * t).sin(), amplitude * turn * (turn * t).cos());
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let jitter = 0.1 * ((noise >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
        recording.time.push(t);
        recording.position.push(x);
        let force = 0.4 * -turn * turn * x + level * v.signum() + 2.0 * v + jitter;
        recording.force.push(sign * force);
    }
    Measured::new(&recording).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn blocks_a_jnd_apart_are_a_jnd_apart_whatever_the_motion_and_the_side_of_the_load_cell() {
    // at 2 N and 50 mm/s, 2 N·s/m add 0.1 N: the level is 2.1 N, and 0.78 N at 2 N are 0.37 JND per newton
    let real = recording(2.0, 0.012, 0.7, 1.0);
    for (level, expected) in [(2.0, 0.0), (2.78, 0.96), (1.64, 0.96)] {
        for (amplitude, frequency, sign) in [(0.012, 0.7, 1.0), (0.008, 1.1, -1.0)] {
            let other = recording(level, amplitude, frequency, sign);
            assert_eq!(other.turned, sign < 0.0);
            let c = compare(&real, &other, None, MARGIN).unwrap_or_else(|e| panic!("{e}"));
            println!("{level} N, {frequency} Hz: {:.3} JND {:.3?}", c.distance.value, c.distance.ci95);
            assert!((c.distance.value - expected).abs() < 0.05, "{:?}", c.distance);
            assert_eq!(c.verdict == Verdict::Same, level == 2.0);
        }
    }
}

#[test]
fn no_speed_in_common_is_said_and_so_is_too_little_sliding() {
    let (slow, fast) = (recording(2.0, 0.004, 0.3, 1.0), recording(2.0, 0.014, 3.0, 1.0));
    let why = compare(&slow, &fast, None, MARGIN).err().map(|e| e.to_string()).unwrap_or_default();
    println!("{why}");
    assert!(why.contains("no speed at which all slide") && why.contains("mm/s"), "{why}");
}
