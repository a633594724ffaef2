//! The virtual coupling in the plane against closed forms.

use friction::planar::{Coulomb, Grain, Law, Vector};
use haptics::planar::{Block, Coupling, Rendered};
use std::f64::consts::{PI, TAU};

const T: f64 = 1e-3;
const COUPLING: Coupling<f64> =
    Coupling { period: T, mass: 0.2, stiffness: 2000.0, damping: 20.0, force_max: 20.0 };

fn dry(level: f64, grain: Grain<f64>) -> Law<f64> {
    Law::Coulomb(Coulomb { level, stiction: level, viscous: 0.0, grain })
}

/// Leads the handle along a path of time, and shows every step with position and velocity of the handle.
fn lead(
    law: &Law<f64>,
    seconds: f64,
    path: impl Fn(f64) -> (Vector<f64>, Vector<f64>),
    field: impl Fn(Vector<f64>) -> Vector<f64>,
    mut see: impl FnMut(f64, Vector<f64>, &Rendered<f64>, &Block<f64>),
) {
    let mut block = Block::at(path(0.0).0);
    for n in 0..(seconds / T) as u32 {
        let t = f64::from(n) * T;
        let (at, velocity) = path(t);
        let felt = COUPLING.step(&mut block, law, at, velocity, &field);
        see(t, velocity, &felt, &block);
    }
}

#[test]
fn a_steady_drag_has_the_force_of_the_level_and_its_direction() {
    // F = level·M²v/|Mv| written out: no law is asked
    let (angle, across, level, speed) = (0.5_f64, 2.0, 1.5, 0.05);
    let law = dry(level, Grain::at(angle, across));
    for k in 0..24 {
        let way = TAU * f64::from(k) / 24.0 + 0.01;
        let v = Vector { x: speed * way.cos(), y: speed * way.sin() };
        let mut last = Vector::default();
        lead(&law, 3.0, |t| (v * t, v), |_| Vector::default(), |_, _, felt, _| last = felt.force);
        let (along, beside) = ((way - angle).cos(), across * across * (way - angle).sin());
        let scale = level / along.hypot(across * (way - angle).sin());
        let expected = Vector {
            x: -scale * (along * angle.cos() - beside * angle.sin()),
            y: -scale * (along * angle.sin() + beside * angle.cos()),
        };
        let off = (last - expected).norm();
        assert!(off < 1e-6, "{way:.3} rad: {last:?}, {expected:?}");
    }
}

#[test]
fn work_of_a_closed_path_is_level_times_length_and_a_field_gives_back() {
    let radius = 0.02;
    let circle = |t: f64| {
        // begins at rest, two turns in 4 s, ends at rest
        let turn = 2.0 * TAU * (t / 4.0 - (TAU * t / 4.0).sin() / TAU);
        let rate = 2.0 * TAU * (1.0 - (TAU * t / 4.0).cos()) / 4.0;
        let (s, c) = turn.sin_cos();
        (Vector { x: radius * (c - 1.0), y: radius * s }, Vector { x: -s, y: c } * (radius * rate))
    };
    // a path of its length under friction alone
    let (level, mut work, mut path) = (1.2, 0.0, 0.0);
    lead(
        &dry(level, Grain::default()),
        4.0,
        circle,
        |_| Vector::default(),
        |_, v, felt, _| {
            work += -felt.force.dot(v) * T;
            path += v.norm() * T;
        },
    );
    println!("friction: {:.3} mJ over {:.3} mm: {:.4} N", 1e3 * work, 1e3 * path, work / path);
    // the block takes the inner lane of the circle
    assert!((work / (level * path) - 1.0).abs() < 0.01);

    // wells 5 mm apart, 0.5 N deep slopes, no friction: the hand gets back what it gave
    let force = |x: f64| -0.5 * (TAU * x / 0.005).sin();
    let field = |p: Vector<f64>| Vector { x: force(p.x), y: force(p.y) };
    let (mut work, mut given) = (0.0, 0.0);
    let slow = |t: f64| {
        let s = (PI * t / 20.0).sin();
        let at = Vector { x: 0.02, y: 0.013 };
        (at * (s * s), at * ((TAU * t / 20.0).sin() * PI / 20.0))
    };
    lead(&dry(0.0, Grain::default()), 20.0, slow, field, |_, v, felt, _| {
        let power = -felt.force.dot(v) * T;
        work += power;
        given += power.max(0.0);
    });
    println!("field: {:.4} mJ of {:.4} mJ are not given back", 1e3 * work, 1e3 * given);
    assert!(given > 1e-3 && work.abs() < 0.05 * given);
}

#[test]
fn a_block_held_by_friction_never_moves() {
    // 0.99 of the level along and across the grain, turned slowly all round
    let (angle, across, level) = (0.3_f64, 2.0, 1.0);
    let law = dry(level, Grain::at(angle, across));
    let at = |t: f64| {
        let (s, c) = (TAU * t / 10.0).sin_cos();
        let grow = (t / 2.0).min(0.99) * level / COUPLING.stiffness;
        let (along, beside) = (grow * c, across * grow * s);
        Vector {
            x: along * angle.cos() - beside * angle.sin(),
            y: along * angle.sin() + beside * angle.cos(),
        }
    };
    let mut most = 0.0_f64;
    // read without a velocity: the damper gives no force
    lead(
        &law,
        20.0,
        |t| (at(t), Vector::default()),
        |_| Vector::default(),
        |_, _, felt, block| {
            assert!(felt.stuck);
            most = most.max(block.position.norm());
        },
    );
    assert_eq!(most, 0.0);
}

#[test]
fn a_coupling_beyond_its_bound_is_refused_with_the_number() {
    // (4M − 2BT)/T²
    let bound = (4.0 * 0.2 - 2.0 * 20.0 * T) / (T * T);
    let at = |stiffness| Coupling { stiffness, ..COUPLING };
    assert!(at(0.999 * bound).validate().is_ok());
    let why = at(1.001 * bound).validate().unwrap_err();
    println!("{why}");
    assert_eq!(why.parameter, "stiffness");
    assert!((why.max / bound - 1.0).abs() < 1e-12);
    // what the bound says, the block does at a handle that is held: it comes to rest, or not
    let swing = |stiffness: f64| {
        let coupling = Coupling { force_max: 1e9, ..at(stiffness) };
        let mut block = Block::at(Vector { x: 1e-3, y: -1e-3 });
        let still = Vector::default();
        for _ in 0..20_000 {
            coupling.step(&mut block, &dry(0.0, Grain::default()), still, still, |_| still);
        }
        block.position.norm()
    };
    let (inside, outside) = (swing(0.999 * bound), swing(1.001 * bound));
    println!("{inside:e} m inside, {outside:e} m outside");
    assert!(inside < 1e-6 && !(outside < 1e-2));
}
