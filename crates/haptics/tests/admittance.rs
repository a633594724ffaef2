//! The admittance renderer against closed forms, a stepped model, and the simulated rig.
#![cfg(feature = "admittance")]

use haptics::bounds::{ClosedLoop, Grasp};
use haptics::renderer::{Contact, Handle};
use haptics::{Device, LawKind, RendererKind, Settings};

const T: f64 = 1e-3;

fn settings(mass: f32, level: f32) -> Settings {
    Settings {
        law: LawKind::Karnopp,
        renderer: RendererKind::Admittance,
        f_static_p: 1.2 * level,
        f_static_n: 1.2 * level,
        f_dynamic_p: level,
        f_dynamic_n: level,
        damping_p: 0.0,
        damping_n: 0.0,
        mass,
        ..Settings::brass()
    }
}

#[test]
fn a_push_below_the_static_friction_moves_nothing() {
    let config = settings(0.4, 2.0).build(&Device::default()).expect("accepted");
    let mut contact = Contact::new(&config, &Handle::default());
    // 2.3 of 2.4 N, with a noise of 0.06 N by a deterministic sequence
    for n in 0..10_000_u32 {
        let noise = 0.06 * ((n.wrapping_mul(2_654_435_761) >> 16) as f32 / 32_768.0 - 1.0);
        let felt = contact.step(&config, &Handle { push: 2.3 + noise, ..Handle::default() });
        assert_eq!((felt.force, felt.block_position, felt.stuck), (0.0, 0.0, true));
    }
}

#[test]
fn noise_of_the_load_cell_broke_a_block_away() {
    let config = settings(0.4, 2.0).build(&Device::default()).expect("accepted");
    // 0.03 N below the static friction of 2.4 N, with noise of ±0.06 N
    let mut handle = Handle::default();
    let mut contact = Contact::new(&config, &handle);
    for _ in 0..30 {
        let _ = contact.step(&config, &handle);
    }
    for n in 0..100_000_u32 {
        let noise = 0.06 * ((n.wrapping_mul(2_654_435_761) >> 16) as f32 / 32_768.0 - 1.0);
        handle.push = 2.37 + noise;
        let felt = contact.step(&config, &handle);
        assert_eq!((felt.block_position, felt.stuck), (0.0, true), "sample {n}");
    }
}

#[test]
fn a_pushed_block_accelerates_by_what_friction_leaves() {
    // the handle follows ideally
    let (mass, level, push) = (0.4, 1.0, 3.0);
    let config = settings(mass, level).build(&Device::default()).expect("accepted");
    let mut handle = Handle { push, ..Handle::default() };
    let mut contact = Contact::new(&config, &handle);
    let mut speed = 0.0;
    for _ in 0..100 {
        let felt = contact.step(&config, &handle);
        speed = felt.block_velocity;
        handle = Handle { position: felt.block_position, velocity: speed, ..handle };
    }
    // a = (F − F_d)/M from the first step on, 0.1 s
    let expected = (push - level) / mass * 0.1;
    assert!((speed / expected - 1.0).abs() < 1e-4, "{speed} m/s, {expected}");
}

#[test]
fn breaks_away_at_the_static_level_and_slides_at_the_dynamic_one() {
    let (level, viscous) = (2.0, 8.0);
    let settings = Settings { damping_p: viscous, damping_n: viscous, ..settings(0.4, level) };
    let config = settings.build(&Device::default()).expect("accepted");
    for sign in [1.0_f32, -1.0] {
        let mut contact = Contact::new(&config, &Handle::default());
        let mut handle = Handle::default();
        let mut broke = None;
        for n in 0..5_000_u16 {
            handle.push = sign * 1e-3 * f32::from(n);
            let felt = contact.step(&config, &handle);
            handle = Handle { position: felt.block_position, velocity: felt.block_velocity, ..handle };
            if broke.is_none() && felt.block_position != 0.0 {
                broke = Some(handle.push.abs());
            }
        }
        // 1.2 times the dynamic level, to the step of the push; the average over a tenth is 9 ms late, at 1 N/s
        let broke = broke.expect("it moves");
        assert!((broke - 9e-3 - 1.2 * level).abs() < 2.1e-3, "{broke} N");
        // a constant push of 3 N slides at (3 − 2)/8 m/s; M/b is 50 ms
        for _ in 0..2_000 {
            handle.push = sign * 3.0;
            let felt = contact.step(&config, &handle);
            handle = Handle { position: felt.block_position, velocity: felt.block_velocity, ..handle };
        }
        assert!((handle.velocity * sign - 0.125).abs() < 1e-4, "{} m/s", handle.velocity);
    }
}

#[test]
fn a_hand_stronger_than_the_actuator_drags_the_block_along() {
    let device = Device::default();
    let config = settings(2.0, 4.0).build(&device).expect("accepted");
    let mut contact = Contact::new(&config, &Handle::default());
    // the handle is torn away while the cell shows nothing
    let far = Handle { position: 0.01, ..Handle::default() };
    let felt = contact.step(&config, &far);
    let spring = Settings::brass().k_vc * (far.position - felt.block_position);
    assert!((spring - device.force_max).abs() < 1e-3 && felt.force == -device.force_max, "{felt:?}");
}

/// Growth of a free motion by small steps: the last tenth over the first.
fn growth(c: &ClosedLoop, block: f64, beyond: f64) -> f64 {
    const FINE: u32 = 400;
    let h = c.period / f64::from(FINE);
    let mass = c.device_mass + c.grasp.mass;
    let (mut x, mut v, mut p, mut w, mut held) = (0.0, 0.1, 0.0, 0.0, 0.0);
    let (mut early, mut late) = (0.0_f64, 0.0_f64);
    for n in 0..4000 {
        // what the cell shows: the hand, and the inertia between hand and cell
        let hand = -c.grasp.damping * v - c.grasp.stiffness * x;
        let acceleration = (held + hand - c.device_damping * v) / mass;
        let cell = hand - (c.grasp.mass + beyond) * acceleration;
        w += c.period / block * cell;
        p += c.period * w;
        let force = c.stiffness * (p - x) + c.damping * (w - v);
        for s in 0..FINE {
            let acting = if f64::from(s) * h < c.delay { held } else { force };
            let hand = -c.grasp.damping * v - c.grasp.stiffness * x;
            v += h * (acting + hand - c.device_damping * v) / mass;
            x += h * v;
        }
        held = force;
        let size = (x - p).abs() * c.stiffness + (v - w).abs();
        if !(size < 1e12) {
            return f64::INFINITY;
        }
        if n < 400 {
            early = early.max(size);
        } else if n >= 3600 {
            late = late.max(size);
        }
    }
    late / early
}

#[test]
fn spectral_radius_separates_growth_from_decay() {
    let firm = Grasp { mass: 0.3, damping: 15.0, stiffness: 1_500.0 };
    for (grasp, delay, k, b, beyond) in [
        (Grasp::default(), 20e-6, 8_000.0, 60.0, 0.05),
        (firm, 20e-6, 8_000.0, 60.0, 0.05),
        (firm, 1e-3, 8_000.0, 30.0, 0.0),
        (Grasp { mass: 0.1, ..firm }, 0.4e-3, 3_000.0, 40.0, 0.07),
    ] {
        let at = ClosedLoop {
            device_mass: 0.692,
            device_damping: 6.92,
            period: T,
            delay,
            grasp,
            stiffness: k,
            damping: b,
        };
        // the lightest stable block
        let (mut low, mut high) = (1e-6, 10.0);
        assert!(at.radius_admittance(high, beyond) < 1.0, "a heavy block is stable");
        while high / low > 1.0001 {
            let middle = f64::sqrt(low * high);
            if at.radius_admittance(middle, beyond) < 1.0 { high = middle } else { low = middle }
        }
        let (inside, outside) = (growth(&at, 1.05 * high, beyond), growth(&at, 0.95 * high, beyond));
        println!(
            "{grasp:?}, delay {delay}: {high:.5} kg; grows by {inside:.1e} inside, {outside:.1e} outside"
        );
        assert!(inside < 0.7 && outside > 2.0);
    }
}

#[test]
fn a_block_too_light_is_refused_with_the_mass_that_is_accepted() {
    let device = Device::default();
    let light = Settings { b_vc: 200.0, ..settings(0.01, 0.5) };
    let Err(refused) = light.validate(&device) else { panic!("accepted") };
    println!("{refused}");
    assert_eq!(refused.parameter, "mass");
    let haptics::Accepted::Between(least, _) = refused.accepted else { panic!("{refused:?}") };
    Settings { mass: least, ..light }.validate(&device).expect("the number it names");
}
