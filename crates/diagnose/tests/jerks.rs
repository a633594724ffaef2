//! Axes that are driven as drives do it: by steps of the commanded speed, at several speeds one after the other, from place to
//! place; recorded at 500 Hz with a position only.

use diagnose::{Diagnosis, Options, Verdict, diagnose};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use signals::{FaultKind, Geometry, Recording};
use std::f64::consts::{PI, TAU};
use untested::draws;

const DT: f64 = 0.002;
const SECONDS: f64 = 30.0;
const SPEEDS: [f64; 5] = [0.15, 0.4, 0.8, 1.5, 2.6];
const INERTIA: f64 = 0.06;

/// Position, velocity and acceleration of a sample.
type Point = (f64, f64, f64);

/// To and fro at each speed, which the axis follows within 8 ms of every change, wherever between two samples that is.
fn jerky(random: &mut ChaCha8Rng) -> Vec<Point> {
    const FOLLOWS: f64 = 0.008;
    const FINE: usize = 40;
    let (mut x, mut v, mut target, mut until) = (0.0_f64, 0.0_f64, 0.0, 0.3);
    let mut points = Vec::new();
    let mut way = 1.0;
    for step in 0..(SECONDS / DT) as usize * FINE {
        let t = step as f64 * DT / FINE as f64;
        if t >= until {
            let speed = SPEEDS[((t / SECONDS * 5.0) as usize).min(4)];
            let rests = target != 0.0 && random.random_bool(0.3);
            (target, until) = if rests {
                (0.0, t + random.random_range(0.1..0.3))
            } else {
                way = if x.abs() > 0.2 { -f64::signum(x) } else { -way };
                (way * speed, t + random.random_range(0.4..1.0) / speed.max(0.6))
            };
        }
        let a = (target - v) / FOLLOWS;
        if step % FINE == 0 {
            points.push((x, v, a));
        }
        let decays = f64::exp(-DT / FINE as f64 / FOLLOWS);
        x += target * DT / FINE as f64 + (v - target) * FOLLOWS * (1.0 - decays);
        v = target + (v - target) * decays;
        // dry friction stops it
        if target == 0.0 && v.abs() < 1e-3 {
            v = 0.0;
        }
    }
    points
}

/// Triangles with round corners, A·asin(0.985 sin φ)/asin 0.985, slow for most of the time and quick at the end.
fn rounded(t: f64) -> Point {
    const ROUND: f64 = 0.985;
    const SLOW: f64 = TAU * 0.08;
    const GAINS: f64 = TAU * 1.1;
    let u = t / SECONDS;
    let (phase, rate) = (SLOW * t + GAINS * SECONDS * u.powi(5) / 5.0, SLOW + GAINS * u.powi(4));
    let quickens = 4.0 * GAINS / SECONDS * u.powi(3);
    let (sine, cosine) = phase.sin_cos();
    let size = 0.6 / ROUND.asin();
    let root = (1.0 - (ROUND * sine).powi(2)).sqrt();
    let slope = size * ROUND * cosine / root;
    let bend = size * ROUND * sine * (ROUND * ROUND - 1.0) / root.powi(3);
    (size * (ROUND * sine).asin(), slope * rate, bend * rate * rate + slope * quickens)
}

/// From place to place along polynomials of the fifth degree, with a rest at each.
fn moves(random: &mut ChaCha8Rng) -> Vec<Point> {
    let mut points = Vec::new();
    let mut from: f64 = 0.0;
    while points.len() < (SECONDS / DT) as usize {
        let to: f64 = random.random_range(-0.95..0.95);
        let way = to - from;
        let takes = (0.26 + 0.41 * way.abs()) * random.random_range(0.7..1.6);
        for i in 0..(takes / DT) as usize {
            let u = i as f64 * DT / takes;
            let x = from + way * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
            let v = way / takes * 30.0 * (u * (1.0 - u)).powi(2);
            points.push((x, v, way / takes.powi(2) * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)));
        }
        let rests = (random.random_range(0.15..0.6) / DT) as usize;
        points.extend(std::iter::repeat_n((to, 0.0, 0.0), rests));
        from = to;
    }
    points
}

fn load((x, v, a): Point, spring: f64) -> f64 {
    let dry = if v == 0.0 { 0.0 } else { 0.5 * v.signum() };
    INERTIA * a + dry + 0.1 * v + spring * x
}

/// What an encoder of 65 536 counts and a torque sensor show of it.
fn recorded(
    points: impl Iterator<Item = Point>,
    torque: impl Iterator<Item = f64>,
    random: &mut ChaCha8Rng,
) -> Recording {
    let noise = Normal::new(0.0, 0.02).expect("a deviation");
    let count = 2.0 * PI / 65_536.0;
    let position: Vec<f64> = points.map(|p| (p.0 / count).round() * count).collect();
    let force = torque.take(position.len()).map(|f| f + noise.sample(random)).collect();
    let time = (0..position.len()).map(|i| i as f64 * DT).collect();
    Recording { geometry: Geometry::Rotary, time, position, force, ..Recording::default() }
}

fn answer(recording: Recording) -> Diagnosis {
    let d = diagnose(&[recording], &[], &Options::default(), &|_, _| ()).expect("accepted");
    println!("{}", d.summary);
    d
}

fn named(d: &Diagnosis) -> Vec<&str> {
    d.missing.iter().map(|m| m.effect.as_str()).collect()
}

/// The first sample of a blow was mended as an outlier, and what was left of it was the largest error of all.
#[test]
fn steps_of_the_speed_were_a_force_over_position_and_acceleration() {
    for seed in draws(3, 8) {
        let of = |spring: f64| {
            let mut random = ChaCha8Rng::seed_from_u64(700 + seed);
            let points = jerky(&mut random);
            let torque = points.iter().map(|p| load(*p, spring));
            answer(recorded(points.iter().copied(), torque, &mut random))
        };
        let nothing = of(0.0);
        assert!(nothing.verdict == Verdict::NoMismatch, "{:?}", named(&nothing));
        assert!(nothing.recording_faults.iter().any(|f| f.kind == FaultKind::UnresolvedBlow));
        let spring = of(0.12);
        assert_eq!(named(&spring), ["spring"]);
        let k = &spring.missing[0].parameters["stiffness"];
        println!("{:.4} ± {:.4} N·m/rad of 0.12", k.value, k.std);
    }
}

/// Only the fast part shows it: a draw of blocks may hold none of them, and the interval of the gain reached below zero.
#[test]
fn a_delay_that_only_the_fast_strokes_show_was_refused() {
    for seed in draws(2, 8) {
        let mut random = ChaCha8Rng::seed_from_u64(720 + seed);
        let samples = (SECONDS / DT) as usize;
        let points = (0..samples).map(|i| rounded(i as f64 * DT));
        let late = (0..samples).map(|i| load(rounded((i as f64 * DT - 0.006).max(0.0)), 0.0));
        let d = answer(recorded(points, late, &mut random));
        assert_eq!(named(&d), ["time_skew"]);
        let lag = &d.missing[0].parameters["tau"];
        println!("{:.3} ± {:.3} ms of 6", 1e3 * lag.value, 1e3 * lag.std);
        assert!((lag.value - 0.006).abs() < 3e-4);
    }
}

#[test]
fn a_load_that_rings_after_each_move_is_compliance() {
    const RINGS: f64 = TAU * 9.66;
    const FINE: usize = 50;
    for seed in draws(2, 8) {
        let mut random = ChaCha8Rng::seed_from_u64(740 + seed);
        let points = moves(&mut random);
        // the load's position and speed, behind a shaft that hardly damps
        let (mut x, mut v) = (0.0, 0.0);
        let torque: Vec<f64> = points
            .windows(2)
            .map(|pair| {
                let twist = |x: f64, v: f64, at: f64| {
                    let (drive, speed) = (pair[0].0 + at * (pair[1].0 - pair[0].0), pair[0].1);
                    RINGS * RINGS * (drive - x) + 0.08 * RINGS * (speed - v)
                };
                let on_it = 0.015 * twist(x, v, 0.0);
                for step in 0..FINE {
                    v += twist(x, v, step as f64 / FINE as f64) * DT / FINE as f64;
                    x += v * DT / FINE as f64;
                }
                load(pair[0], 0.0) + on_it
            })
            .collect();
        let d = answer(recorded(points[..torque.len()].iter().copied(), torque.into_iter(), &mut random));
        assert_eq!(named(&d), ["compliance"]);
        let frequency = &d.missing[0].parameters["frequency"];
        println!("{:.3} ± {:.3} Hz of 9.66", frequency.value, frequency.std);
        assert!((frequency.value - 9.66).abs() < 0.1);
    }
}
