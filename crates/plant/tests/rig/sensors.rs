//! Sensor readings against the true state.

use friction::{Custom, Motion};
use plant::{HandForce, NoHand, Rig, RigConfig, Sensor, Sensors, Zoh};

fn slick() -> Custom<impl Fn(&Motion<f64>) -> f64 + Clone> {
    Custom(|_: &Motion<f64>| 0.0)
}

/// Time stamps unwrapped to i64 ticks, from differences.
struct Unwrap {
    last: u32,
    ticks: i64,
}

impl Unwrap {
    fn next(&mut self, stamp: u32) -> i64 {
        self.ticks += i64::from(stamp.wrapping_sub(self.last) as i32);
        self.last = stamp;
        self.ticks
    }
}

/// Runs a damped handle through reversals and compares every reported edge with the exact trajectory.
/// Returns (edges checked, worst edge time error in ticks, worst in metres).
fn edges_against_closed_form(substeps: u32, jitter: f64, seconds: u32) -> (usize, f64, f64) {
    let config = RigConfig {
        actuation_delay: 0,
        stroke: None,
        substeps,
        clock_jitter_ticks: jitter,
        device_damping: 60.0,
        ..RigConfig::free_handle()
    };
    let mut rig = Rig::new(config, slick(), 5).unwrap();
    let resolution = config.calibration.metre_per_count;
    let tick_hz = f64::from(config.calibration.tick_hz);
    let (mut edge, mut sample) = (Unwrap { last: 0, ticks: 0 }, Unwrap { last: 0, ticks: 0 });
    let mut before = rig.truth();
    let mut last_edge = 0;
    let (mut checked, mut worst_ticks, mut worst_metres) = (0, 0.0f64, 0.0f64);
    for k in 0..seconds * 1000 {
        let force = 6.0 * (f64::from(k) * 0.013).sin();
        let sensors = rig.tick(force, &mut NoHand);
        let now = rig.truth();
        let (edge_ticks, sample_ticks) = (edge.next(sensors.edge_ticks), sample.next(sensors.sample_ticks));
        assert!(edge_ticks <= sample_ticks, "an edge from the future");
        assert!((sample_ticks as f64 / tick_hz - now.time).abs() < 1e-8);
        let count = (now.position / resolution + 0.5).floor() as i64;
        assert_eq!(sensors.count as i32, count as i32);
        if edge_ticks != last_edge {
            // the exact position at the stamp, from the state at the start of the period
            let since = edge_ticks as f64 / tick_hz - before.time;
            let zoh = Zoh::new(config.device_mass, config.device_damping, since.max(1e-12));
            let (moved, velocity) = zoh.advance(before.velocity, force);
            let at_edge = before.position + moved;
            let nearest_edge = ((at_edge / resolution).floor() + 0.5) * resolution;
            let metres = (at_edge - nearest_edge).abs();
            if velocity.abs() > 1e-3 {
                checked += 1;
                worst_metres = worst_metres.max(metres);
                worst_ticks = worst_ticks.max(metres / velocity.abs() * tick_hz);
            }
        }
        last_edge = edge_ticks;
        before = now;
    }
    (checked, worst_ticks, worst_metres)
}

#[test]
fn edges_are_timed_to_a_tick() {
    for (substeps, jitter) in [(20, 0.0), (10, 0.0), (20, 500.0)] {
        let (checked, ticks, metres) = edges_against_closed_form(substeps, jitter, 3);
        println!(
            "{substeps} substeps, clock jitter {jitter} ticks: {checked} edges, worst {ticks:.2} ticks ({:.1} ns), {metres:.1e} m",
            ticks / 0.17
        );
        // one tick because stamps are whole ticks, and the rest is the parabola through a substep
        assert!(checked > 1000 && ticks < 1.2);
    }
}

#[test]
fn time_stamps_wrap() {
    // 170 MHz in 32 bits wraps after 25.3 s
    let (checked, ticks, _) = edges_against_closed_form(20, 0.0, 60);
    println!("{checked} edges over two wraps, worst {ticks:.2} ticks");
    assert!(checked > 20_000 && ticks < 1.2);
}

#[test]
fn resting_handle_is_silent() {
    // at rest on an edge the count does not flicker, and the stamp does not move
    let config = RigConfig { start_position: 1.285e-6, ..RigConfig::default() };
    let law = Custom(|m: &Motion<f64>| (m.applied + m.mass * m.velocity / m.dt).clamp(-1.0, 1.0));
    let mut rig = Rig::new(config, law, 9).unwrap();
    let first = rig.sensors();
    for k in 0..2000 {
        let s = rig.tick(if k % 2 == 0 { 1.0 } else { -1.0 }, &mut NoHand);
        assert_eq!((s.count, s.edge_ticks), (first.count, first.edge_ticks));
    }
}

fn statistics(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}

#[test]
fn noise_gain_and_offset_match_the_configuration() {
    // the block held by friction at 1.5 N, accelerometer at rest
    let law = Custom(|m: &Motion<f64>| (m.applied + m.mass * m.velocity / m.dt).clamp(-9.0, 9.0));
    let config = RigConfig {
        device_friction_p: 0.0,
        load: Sensor { noise: 0.062, gain: 1.02, offset: 0.3 },
        accel: Sensor { noise: 0.2379, gain: 0.97, offset: -1.5 },
        ..RigConfig::default()
    };
    let mut rig = Rig::new(config, law, 11).unwrap();
    let (mut load, mut accel) = (Vec::new(), Vec::new());
    for k in 0..50_000 {
        let s = rig.tick(1.5, &mut NoHand);
        if k > 1 {
            load.push(config.calibration.load.to_si(s.load_code));
            accel.push(config.calibration.accel.to_si(s.accel_code));
        }
    }
    let ((load_mean, load_std), (accel_mean, accel_std)) = (statistics(&load), statistics(&accel));
    println!(
        "load cell {load_mean:.4} ± {load_std:.4} N (1.83 ± 0.062), accelerometer {accel_mean:.4} ± {accel_std:.4} m/s² (−1.5 ± 0.2379)"
    );
    // five standard errors of mean and of std
    let n = (load.len() as f64).sqrt();
    assert!((load_mean - (1.5 * 1.02 + 0.3)).abs() < 5.0 * 0.062 / n);
    assert!((accel_mean + 1.5).abs() < 5.0 * 0.2379 / n);
    assert!((load_std / 0.062 - 1.0).abs() < 5.0 / (2.0f64.sqrt() * n));
    assert!((accel_std / 0.2379 - 1.0).abs() < 5.0 / (2.0f64.sqrt() * n));
    // white: neighbouring samples are uncorrelated, and so are the two sensors
    let correlation = |a: &[f64], b: &[f64], (am, asd): (f64, f64), (bm, bsd): (f64, f64)| {
        a.iter().zip(b).map(|(x, y)| (x - am) * (y - bm)).sum::<f64>() / (a.len() as f64 * asd * bsd)
    };
    let neighbours =
        correlation(&load[1..], &load[..load.len() - 1], (load_mean, load_std), (load_mean, load_std));
    let across = correlation(&load, &accel, (load_mean, load_std), (accel_mean, accel_std));
    println!("correlation: neighbours {neighbours:.4}, across {across:.4}, 5/√n = {:.4}", 5.0 / n);
    assert!(neighbours.abs() < 5.0 / n && across.abs() < 5.0 / n);
}

/// One second of a pushed block, as codes.
fn codes(seed: u64, config: RigConfig) -> Vec<Sensors> {
    let law = Custom(|m: &Motion<f64>| (m.applied + m.mass * m.velocity / m.dt).clamp(-1.0, 1.0));
    let mut rig = Rig::new(config, law, seed).unwrap();
    let mut hand = HandForce::Sine { amplitude: 4.0, frequency: 3.0, offset: 0.0 };
    (0..1000).map(|_| rig.tick(0.5, &mut hand)).collect()
}

#[test]
fn a_seed_repeats_bit_for_bit() {
    let jittered = RigConfig { clock_jitter_ticks: 100.0, ..RigConfig::default() };
    assert_eq!(codes(7, jittered), codes(7, jittered));
    assert_ne!(codes(7, jittered), codes(8, jittered));
    // every sensor has its own stream: silencing one leaves the codes of the other
    let silent = RigConfig { load: Sensor { noise: 0.0, gain: 1.0, offset: 0.0 }, ..RigConfig::default() };
    let accel = |s: Vec<Sensors>| s.into_iter().map(|s| s.accel_code).collect::<Vec<_>>();
    assert_eq!(accel(codes(7, silent)), accel(codes(7, RigConfig::default())));
    // known codes: the same on every platform and in every version, or it is a visible change
    let last = codes(7, RigConfig::default()).pop().unwrap();
    println!("{last:?}");
    assert_eq!(
        last,
        Sensors {
            sample_ticks: 170_000_000,
            count: 3469,
            edge_ticks: 169_992_679,
            load_code: 32_682,
            accel_code: 32_910
        }
    );
}

#[test]
fn reset_repeats_the_run() {
    let law = Custom(|m: &Motion<f64>| (m.applied + m.mass * m.velocity / m.dt).clamp(-1.0, 1.0));
    let mut rig = Rig::new(RigConfig::default(), law, 4).unwrap();
    let run = |rig: &mut Rig<_>| (0..200).map(|_| rig.tick(4.0, &mut NoHand)).collect::<Vec<_>>();
    let first = run(&mut rig);
    rig.reset();
    assert_eq!(rig.truth().position, 0.0);
    assert_eq!(run(&mut rig), first);
}

#[test]
fn swapping_the_surface_takes_effect_at_once() {
    fn dry(level: f64) -> Custom<impl Fn(&Motion<f64>) -> f64 + Clone> {
        Custom(move |m: &Motion<f64>| (m.applied + m.mass * m.velocity / m.dt).clamp(-level, level))
    }
    let config = RigConfig { load: Sensor { noise: 0.0, gain: 1.0, offset: 0.0 }, ..RigConfig::default() };
    let mut rig = Rig::new(config, dry(1.0), 4).unwrap();
    for _ in 0..20 {
        rig.tick(6.0, &mut NoHand);
    }
    assert!((rig.truth().friction - 1.0).abs() < 1e-12);
    rig.set_law(dry(3.0)).unwrap();
    rig.tick(6.0, &mut NoHand);
    assert!((rig.truth().friction - 3.0).abs() < 1e-12);
    let t = rig.truth();
    assert!((t.force_at_load_cell - (0.419 * t.acceleration + 3.0)).abs() < 1e-12);
    // without a block the load cell carries nothing
    rig.set_block(0.0, dry(3.0)).unwrap();
    let s = rig.tick(6.0, &mut NoHand);
    assert_eq!((rig.truth().force_at_load_cell, s.load_code), (0.0, 32_768));
    // a rejected block leaves the rig unchanged
    let refused = rig.set_block(-1.0, dry(3.0)).unwrap_err();
    println!("{refused}");
    assert_eq!(rig.config().block_mass, 0.0);
}

#[test]
fn rejected_settings_name_the_accepted_range() {
    let bad = [
        RigConfig { device_mass: 0.0, ..RigConfig::default() },
        RigConfig { substeps: 9, ..RigConfig::default() },
        RigConfig { stop_stiffness: 1e12, ..RigConfig::default() },
        RigConfig { force_max: Some(f64::NAN), ..RigConfig::default() },
        RigConfig { load: Sensor { noise: -1.0, gain: 1.0, offset: 0.0 }, ..RigConfig::default() },
        RigConfig {
            coupling: plant::Coupling::Compliant { stiffness: f64::INFINITY, damping: 0.0 },
            ..RigConfig::default()
        },
    ];
    let names =
        ["device_mass", "substeps", "stop_stiffness", "force_max", "load.noise", "coupling.stiffness"];
    for (config, name) in bad.into_iter().zip(names) {
        let error = Rig::new(config, slick(), 1).err().unwrap();
        println!("{error}");
        assert_eq!(error.parameter, name);
    }
}
