//! The smoother against polynomials, against motions of a simulator of its own, and over what breaks recordings.

use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use signals::{Motion, Observation, Observed, estimate_motion};
use std::f64::consts::TAU;

/// Motion at the stamps, without error.
#[derive(Default)]
struct Truth {
    time: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
}

/// A mass on a bristle of friction (Dahl, plus viscosity), pushed by a controller along a sum of sines, and its stop.
struct Rig {
    mass: f64,
    coulomb: f64,
    /// Length over which the bristle bends, m.
    bend: f64,
    /// Amplitude, m, and frequency, Hz, of the first sine.
    stroke: (f64, f64),
    /// A wall stands here, m.
    wall: f64,
}

impl Rig {
    fn run(&self, rate: f64, seconds: f64, seed: u64) -> Truth {
        let substeps = (40_000.0 / rate).ceil() as usize;
        let (dt, h) = (1.0 / rate, 1.0 / rate / substeps as f64);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let phases: Vec<f64> = (0..3).map(|_| 2.0 * draw()).collect();
        let (mut x, mut v, mut z, mut push) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
        let mut out = Truth::default();
        for i in 0..(seconds * rate) as usize {
            let mut a = 0.0;
            // a motor's ripple and a hand: force noise of a few milliseconds
            for s in 0..substeps {
                let t = i as f64 * dt + s as f64 * h;
                let (amplitude, hz) = self.stroke;
                let phase = |k: usize| TAU * hz * [1.0, 2.3, 3.7][k] * t + phases[k];
                let share = [1.0, 0.3, 0.15];
                let target: f64 = (0..3).map(|k| amplitude * share[k] * phase(k).sin()).sum();
                push += h / 5e-3 * (-push) + (h / 5e-3).sqrt() * 0.05 * draw();
                let stiffness = self.mass * (TAU * 12.0).powi(2);
                let drive = stiffness * (target - x) - 1.4 * self.mass * TAU * 12.0 * v + push;
                let wall = if x > self.wall { -2e5 * (x - self.wall) - 50.0 * v } else { 0.0 };
                a = (drive - self.coulomb * z - 0.5 * v + wall) / self.mass;
                if s == 0 {
                    out.time.push(t);
                    out.position.push(x);
                    out.velocity.push(v);
                    out.acceleration.push(a);
                }
                let dx = h * (v + 0.5 * h * a);
                v += h * a;
                x += dx;
                // exact over a step of constant direction
                let side = dx.signum();
                z = side + (z - side) * (-dx.abs() / self.bend).exp();
            }
            let _ = a;
        }
        out
    }
}

/// Standard deviations of the noise of the three channels, 0 where a channel is missing, and the encoder's step.
#[derive(Clone, Copy)]
struct Sensors {
    noise: [f64; 3],
    quantum: f64,
}

impl Sensors {
    fn read(&self, truth: &Truth, seed: u64) -> [Vec<f64>; 3] {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x5e45);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let mut noisy =
            |series: &[f64], std: f64| -> Vec<f64> { series.iter().map(|x| x + std * draw()).collect() };
        let mut position = noisy(&truth.position, self.noise[0]);
        if self.quantum > 0.0 {
            position.iter_mut().for_each(|x| *x = (*x / self.quantum).round() * self.quantum);
        }
        [position, noisy(&truth.velocity, self.noise[1]), noisy(&truth.acceleration, self.noise[2])]
    }

    fn motion(&self, truth: &Truth, seed: u64) -> Motion {
        let channels = self.read(truth, seed);
        let kinds = [Observed::Position, Observed::Velocity, Observed::Acceleration];
        let observations: Vec<Observation> = kinds
            .iter()
            .zip(&channels)
            .enumerate()
            .filter(|(c, _)| *c == 0 || self.noise[*c] > 0.0)
            .map(|(_, (kind, values))| Observation::new(*kind, values))
            .collect();
        estimate_motion(&truth.time, &observations).unwrap()
    }
}

/// Normalised squared errors of x, v and a: over all samples, and over those within `near` of a reversal.
fn errors(truth: &Truth, m: &Motion, near: usize) -> ([f64; 3], [f64; 3]) {
    let n = truth.time.len();
    let mut at = vec![false; n];
    for i in 1..n {
        if truth.velocity[i] * truth.velocity[i - 1] <= 0.0 {
            at[i.saturating_sub(near)..(i + near).min(n)].fill(true);
        }
    }
    let z = |i: usize| {
        [
            (m.position[i] - truth.position[i]) / m.position_std(i),
            (m.velocity[i] - truth.velocity[i]) / m.velocity_std(i),
            (m.acceleration[i] - truth.acceleration[i]) / m.acceleration_std(i),
        ]
        .map(|z| z * z)
    };
    let mean = |wanted: &dyn Fn(usize) -> bool| {
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for i in (0..n).filter(|i| wanted(*i)) {
            sum.iter_mut().zip(z(i)).for_each(|(s, z)| *s += z);
            count += 1.0;
        }
        sum.map(|s| s / f64::max(count, 1.0))
    };
    (mean(&|_| true), mean(&|i| at[i]))
}

/// Sums of normalised squared errors over seeds, for one rig and one set of sensors.
fn pooled(rig: &Rig, sensors: &Sensors, rate: f64) -> ([f64; 3], [f64; 3]) {
    let (mut all, mut near) = ([0.0; 3], [0.0; 3]);
    for seed in 0..SEEDS {
        let truth = rig.run(rate, 4.0, seed);
        let (a, n) = errors(&truth, &sensors.motion(&truth, seed), (0.01 * rate) as usize);
        for c in 0..3 {
            all[c] += a[c] / SEEDS as f64;
            near[c] += n[c] / SEEDS as f64;
        }
    }
    (all, near)
}

const SEEDS: u64 = 4;
const BRASS: Rig = Rig { mass: 0.4, coulomb: 1.7, bend: 3e-5, stroke: (0.01, 1.2), wall: 1.0 };
const STOP: Rig = Rig { wall: 0.008, ..BRASS };
const EVERY_CHANNEL: Sensors = Sensors { noise: [1e-6, 3.18e-3, 0.2379], quantum: 2.57e-6 };
const ENCODER: Sensors = Sensors { noise: [1e-6, 0.0, 0.0], quantum: 2.57e-6 };

#[test]
fn covariance_holds_the_errors_of_a_simulated_slide_and_at_its_reversals() {
    let thesis = Sensors { noise: [5.76e-5, 3.18e-3, 0.2379], quantum: 0.0 };
    for (name, rig) in [("slide", &BRASS), ("stop", &STOP)] {
        for (which, sensors) in [("every channel", &EVERY_CHANNEL), ("encoder", &ENCODER), ("noisy", &thesis)]
        {
            let (all, near) = pooled(rig, sensors, 1000.0);
            println!("{name}, {which}: squared errors over variance {all:.2?}, at reversals {near:.2?}");
            // A motion between two reversals is smoother than white jerk, so the covariance errs on the safe side.
            for errors in [all, near] {
                let [x, v, a] = errors;
                assert!((0.7..1.35).contains(&x) && (0.5..1.25).contains(&v) && (0.25..1.2).contains(&a));
            }
        }
    }
}

#[test]
fn covariance_is_near_the_errors_where_the_jerk_is_white_everywhere() {
    let (mut sums, mut count) = ([0.0; 3], 0.0);
    for seed in 0..20 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let (h, substeps) = (5e-5, 20);
        let mut truth = Truth::default();
        let (mut x, mut v, mut a) = (0.0, 0.0, 0.0);
        for i in 0..2000 {
            truth.time.push(i as f64 * h * f64::from(substeps));
            truth.position.push(x);
            truth.velocity.push(v);
            truth.acceleration.push(a);
            for _ in 0..substeps {
                let jerk = 30.0 * draw() / f64::sqrt(h);
                x += h * (v + 0.5 * h * (a + h * jerk / 3.0));
                v += h * (a + 0.5 * h * jerk);
                a += h * jerk;
            }
        }
        let m = Sensors { noise: [2e-5, 3e-3, 0.0], quantum: 0.0 }.motion(&truth, seed);
        let (all, _) = errors(&truth, &m, 1);
        sums.iter_mut().zip(all).for_each(|(s, z)| *s += z);
        count += 1.0;
    }
    let mean = sums.map(|s| s / count);
    println!("squared errors over variance {mean:.3?}");
    // heavy tails follow chance a little: the acceleration is sure of itself by a fifth in standard deviations
    assert!((mean[0] - 1.0).abs() < 0.05 && (mean[1] - 1.0).abs() < 0.25 && (mean[2] - 1.0).abs() < 0.55);
}

#[test]
fn direction_is_as_likely_as_its_posterior_says() {
    const BINS: usize = 10;
    for (which, sensors) in [("every channel", &EVERY_CHANNEL), ("encoder", &ENCODER)] {
        let mut bins = [(0.0, 0.0, 0.0_f64); BINS];
        for seed in 0..12 {
            let truth = BRASS.run(1000.0, 4.0, seed);
            for (e, v) in sensors.motion(&truth, seed).direction().iter().zip(&truth.velocity) {
                let bin = ((0.5 * (e + 1.0) * BINS as f64) as usize).min(BINS - 1);
                bins[bin].0 += e;
                bins[bin].1 += f64::signum(*v);
                bins[bin].2 += 1.0;
            }
        }
        for (expected, seen, count) in bins.into_iter().filter(|b| b.2 >= 40.0) {
            let (expected, seen) = (expected / count, seen / count);
            // neighbouring samples err together: a fifth of them are independent
            let chance = 3.0 * ((1.0 - expected * expected) / (0.2 * count)).sqrt();
            println!("{which}: {expected:+.3} expected, {seen:+.3} seen in {count} samples");
            assert!((expected - seen).abs() < 0.12 + chance, "{expected} against {seen}");
        }
    }
}

/// A cubic, its derivatives, and the observations of all three without noise.
fn cubic(time: &[f64], c: [f64; 4]) -> [Vec<f64>; 3] {
    let each = |f: &dyn Fn(f64) -> f64| time.iter().map(|t| f(*t)).collect();
    [
        each(&|t| c[0] + t * (c[1] + t * (c[2] + t * c[3]))),
        each(&|t| c[1] + t * (2.0 * c[2] + t * 3.0 * c[3])),
        each(&|t| 2.0 * c[2] + 6.0 * c[3] * t),
    ]
}

fn position_only(time: &[f64], position: &[f64], std: f64) -> Motion {
    let observation = Observation { std, quantum: 0.0, ..Observation::new(Observed::Position, position) };
    estimate_motion(time, &[observation]).unwrap()
}

#[test]
fn constant_jerk_comes_back_inside_and_constant_acceleration_everywhere() {
    let time: Vec<f64> = (0..400).map(|i| 1e-3 * f64::from(i)).collect();
    for (c, inside) in [([0.1, 0.5, -3.0, 0.0], 0..400), ([0.1, 0.5, -3.0, 12.0], 60..340)] {
        let [x, v, a] = cubic(&time, c);
        let m = position_only(&time, &x, 1e-7);
        for i in inside {
            let (dv, da) = ((m.velocity[i] - v[i]).abs(), (m.acceleration[i] - a[i]).abs());
            assert!(dv < 2e-6 && da < 2e-3, "sample {i}: {dv:.1e} m/s, {da:.1e} m/s²");
            assert!((m.position[i] - x[i]).abs() < 1e-8);
        }
    }
}

#[test]
fn a_gap_widens_the_covariance_and_a_repeated_stamp_is_two_readings() {
    let clock =
        |kept: &dyn Fn(usize) -> bool| (0..600).filter(|i| kept(*i)).map(|i| 1e-3 * i as f64).collect();
    let place = |t: &f64| 0.01 * (TAU * 1.5 * t).sin();
    let whole: Vec<f64> = clock(&|_| true);
    let gap: Vec<f64> = clock(&|i| !(300..330).contains(&i));
    let read = |time: &[f64]| -> Vec<f64> { time.iter().map(place).collect() };
    let (a, b) = (position_only(&whole, &read(&whole), 1e-6), position_only(&gap, &read(&gap), 1e-6));
    let at = |t: &f64| 0.01 * TAU * 1.5 * (TAU * 1.5 * t).cos();
    for (t, v) in gap.iter().zip(&b.velocity) {
        assert!((v - at(t)).abs() < 2e-3, "{t} s: {v} for {}", at(t));
    }
    assert!(b.velocity_std(299) > 1.2 * a.velocity_std(299));
    let mut twice = whole.clone();
    twice.insert(100, whole[100]);
    let c = position_only(&twice, &read(&twice), 1e-6);
    assert_eq!(c.len(), 601);
    assert!((c.velocity[100] - c.velocity[101]).abs() < 1e-9 && c.position_std(100) < a.position_std(100));
    // a pause of a day forgets all but what both sides show
    let mut apart = whole.clone();
    apart[300..].iter_mut().for_each(|t| *t += 86_400.0);
    let d = position_only(&apart, &read(&whole), 1e-6);
    assert!(d.velocity.iter().zip(&whole).all(|(v, t)| (v - at(t)).abs() < 5e-3));
}

#[test]
fn lag_scale_and_zero_of_a_channel_are_undone() {
    let time: Vec<f64> = (0..2000).map(|i| 1e-3 * f64::from(i)).collect();
    let at = |t: f64| 0.05 * (TAU * 2.0 * t).cos() * TAU * 2.0;
    let position: Vec<f64> = time.iter().map(|t| 0.05 * (TAU * 2.0 * t).sin()).collect();
    let velocity: Vec<f64> = time.iter().map(|t| 1.05 * at(t - 0.0043) + 0.2).collect();
    let observations = [
        Observation { std: 1e-3, ..Observation::new(Observed::Position, &position) },
        Observation {
            std: 1e-5,
            lag: 0.0043,
            scale: 1.05,
            zero: 0.2,
            ..Observation::new(Observed::Velocity, &velocity)
        },
    ];
    let m = estimate_motion(&time, &observations).unwrap();
    let worst = (20..1980).map(|i| (m.velocity[i] - at(time[i])).abs()).fold(0.0, f64::max);
    println!("largest error of the velocity {worst:.1e} m/s");
    assert!(worst < 3e-4);
}

#[test]
fn one_sample_equal_values_and_missing_values_end_in_finite_numbers() {
    let finite = |m: &Motion| {
        let means = m.position.iter().chain(&m.velocity).chain(&m.acceleration);
        means.chain(m.covariance.iter().flatten()).all(|x| x.is_finite())
    };
    let one = estimate_motion(&[2.0], &[Observation::new(Observed::Position, &[0.3])]).unwrap();
    assert!(finite(&one) && (one.position[0] - 0.3).abs() < 1e-9 && one.direction() == [0.0]);
    let time: Vec<f64> = (0..300).map(|i| 1e-3 * f64::from(i)).collect();
    for value in [0.0, 0.7, -1e9, 1e-300] {
        let still = estimate_motion(&time, &[Observation::new(Observed::Position, &[value; 300])]).unwrap();
        assert!(finite(&still) && still.velocity.iter().all(|v| v.abs() <= 1e-3 * value.abs()));
    }
    let mut position: Vec<f64> = time.iter().map(|t| t * t).collect();
    position[100..200].fill(f64::NAN);
    assert!(finite(&position_only(&time, &position, 1e-6)));
    let all = Observation::new(Observed::Velocity, &position);
    assert!(finite(&estimate_motion(&time, &[all]).unwrap()));
    assert!(estimate_motion(&[], &[]).unwrap().is_empty());
}

#[test]
fn what_cannot_be_used_is_refused_by_name() {
    let x = [0.0, 1.0, 2.0];
    let good = Observation::new(Observed::Position, &x);
    let refused = |time: &[f64], o: Observation, name: &str| {
        let error = estimate_motion(time, &[o]).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    };
    refused(&[0.0, 1.0], good, "values of the position channel = 3");
    refused(&[0.0, 2.0, 1.0], good, "time[2] = 1");
    refused(&[0.0, f64::NAN, 1.0], good, "time[1] = NaN");
    refused(&[0.0, 1.0, 2.0], Observation { std: -1.0, ..good }, "std of the position channel = -1");
    refused(&[0.0, 1.0, 2.0], Observation { scale: 0.0, ..good }, "scale of the position channel = 0");
    refused(&[0.0, 1.0, 2.0], Observation { lag: f64::INFINITY, ..good }, "lag of the position channel");
    assert!(estimate_motion(&x, &[]).is_err());
    assert!(estimate_motion(&x, &[Observation::new(Observed::Position, &[f64::NAN; 3])]).is_err());
}

#[test]
fn a_million_samples_are_smoothed() {
    let n = 1_000_000;
    let time: Vec<f64> = (0..n).map(|i| 1e-3 * f64::from(i)).collect();
    let position: Vec<f64> =
        time.iter().map(|t| ((0.01 * (TAU * 0.7 * t).sin()) / 2.57e-6).round() * 2.57e-6).collect();
    let m = estimate_motion(&time, &[Observation::new(Observed::Position, &position)]).unwrap();
    let at = |t: f64| 0.01 * TAU * 0.7 * (TAU * 0.7 * t).cos();
    let square: f64 = m.velocity.iter().zip(&time).map(|(v, t)| (v - at(*t)).powi(2)).sum();
    let rms = (square / f64::from(n)).sqrt();
    println!("velocity rms error {rms:.1e} m/s");
    assert!(rms < 5e-4);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_clock_and_any_values_give_finite_motion(
        steps in prop::collection::vec(prop_oneof![Just(0.0), 1e-6..1e-1f64, 1.0..1e4f64], 1..80),
        values in prop::collection::vec(-1e3..1e3f64, 80),
        size in -6..6i32,
    ) {
        let time: Vec<f64> = steps.iter().scan(0.0, |t, d| { *t += d; Some(*t) }).collect();
        let values: Vec<f64> = values.iter().take(time.len()).map(|x| x * 10f64.powi(size)).collect();
        for observed in [Observed::Position, Observed::Velocity, Observed::Acceleration] {
            let m = estimate_motion(&time, &[Observation::new(observed, &values)]).unwrap();
            for i in 0..m.len() {
                prop_assert!(m.position[i].is_finite() && m.velocity[i].is_finite() && m.acceleration[i].is_finite());
                prop_assert!(m.position_std(i).is_finite() && m.acceleration_std(i).is_finite());
            }
            prop_assert!(m.direction().iter().all(|e| e.abs() <= 1.0));
        }
    }
}
