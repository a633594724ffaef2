//! A body at rest under a load below break-away stays where it is; above, it goes.

use crate::common::{Block, MASS, close, dahl, laws, lugre, rubber};
use friction::{Coulomb, FrictionLaw, Karnopp, Law, Motion};

const DT: f64 = 1e-3;

/// Raises the load within 4 s, smoothly so that nothing rings, then holds it; the position at 5 s and at 60 s.
fn hold(law: Law<f64>, load: f64) -> (f64, f64) {
    let mut block = Block::new(law, MASS, DT);
    for k in 0..5000 {
        let share = (k as f64 * DT / 4.0).min(1.0);
        block.push(load * 0.5 * (1.0 - (core::f64::consts::PI * share).cos()));
    }
    let settled = block.x;
    for _ in 5000..60_000 {
        block.push(load);
    }
    (settled, block.x)
}

#[test]
fn every_law_holds_below_break_away_without_creep() {
    for (law, d_p, d_n) in laws() {
        for load in [0.3 * d_p, 0.9 * d_p, 0.99 * d_p, -0.3 * d_n, -0.9 * d_n, -0.99 * d_n] {
            let (settled, end) = hold(law, load);
            println!(
                "{:8} load {load:7.4} N: at {settled:+.3e} m, creep in 55 s {:+.1e} m",
                law.id(),
                end - settled
            );
            match law {
                // rigid: not the last bit moves
                Law::Karnopp(_) | Law::Coulomb(_) => assert_eq!((settled, end), (0.0, 0.0)),
                // elastic: where the bristles balance the load, and no further
                _ => {
                    let limit = if load > 0.0 { d_p } else { d_n };
                    let rest = -load.signum() * limit / 50_000.0 * (1.0 - load.abs() / limit).ln();
                    assert!(close(settled / rest, 1.0, 0.02), "{settled} against {rest}");
                    assert!((end - settled).abs() < 1e-10); // what still rings; an encoder count is 2.6e-6 m
                }
            }
        }
    }
}

#[test]
fn every_law_lets_go_above_break_away() {
    for (law, d_p, d_n) in laws() {
        for load in [1.02 * d_p, -1.02 * d_n] {
            let (_, end) = hold(law, load);
            println!("{:8} load {load:7.4} N: {end:+.3} m in 60 s", law.id());
            assert!(end * load.signum() > 0.05);
        }
    }
}

#[test]
fn karnopp_stops_a_body_inside_its_band() {
    let mut block = Block::new(rubber(), MASS, DT);
    block.v = 0.9 * rubber().delta_v;
    for _ in 0..20 {
        block.push(1.0); // balanced as printed, this would creep on at 18 mm/s
    }
    let stopped = block.x;
    assert!(stopped < 1e-3);
    for _ in 0..10_000 {
        block.push(1.0);
    }
    println!("stopped at {stopped:.2e} m, then moved {:.1e} m in 10 s", block.x - stopped);
    assert!((block.x - stopped).abs() < 1e-15);
}

#[test]
fn karnopp_without_mass_balances_the_load() {
    let law = rubber();
    for velocity in [-0.019, -1e-9, 0.0, 1e-9, 0.019] {
        for (applied, friction) in [(1.0, 1.0), (-1.0, -1.0), (50.0, law.d_p), (-50.0, -law.d_n)] {
            let motion = Motion { dt: DT, velocity, applied, ..Motion::default() };
            assert_eq!(law.step(&mut (), &motion), friction, "v {velocity} F_a {applied}");
        }
    }
}

#[test]
fn a_vanishing_band_still_sticks() {
    let law = Karnopp { delta_v: 0.0, ..rubber() };
    let (_, end) = hold(Law::Karnopp(law), 2.0);
    assert_eq!(end, 0.0);
}

#[test]
fn coulomb_has_static_and_dynamic_levels() {
    let law =
        Coulomb { level_p: 2.0, level_n: 2.0, static_p: 3.0, static_n: 3.0, viscous_p: 0.0, viscous_n: 0.0 };
    let mut block = Block::new(law, MASS, DT);
    let mut broke_away = None;
    for k in 0..4000 {
        let load = k as f64 * 1e-3;
        block.push(load);
        if block.v > 0.0 && broke_away.is_none() {
            broke_away = Some((load, block.friction));
        }
    }
    println!("load and friction at break-away: {broke_away:?}");
    let (load, friction) = broke_away.expect("4 N are more than 3 N");
    assert!((3.0..3.0011).contains(&load));
    assert_eq!(friction, 2.0);
    // 2.5 N cannot start it but keep it going
    let (before, v) = (block.x, block.v);
    for _ in 0..100 {
        block.push(2.5);
    }
    assert!(block.x > before && block.v > v);
}

#[test]
fn a_reversal_needs_break_away() {
    // −2.5 N reverses a body only if the static level of the other direction lets it.
    let law =
        Coulomb { level_p: 2.0, level_n: 2.0, static_p: 3.0, static_n: 3.0, viscous_p: 0.0, viscous_n: 0.0 };
    for (load, turns) in [(-2.5, false), (-3.5, true)] {
        let mut block = Block::new(law, MASS, DT);
        block.v = 0.1;
        block.state.sliding = true;
        for _ in 0..500 {
            block.push(load);
        }
        println!("{load} N: v = {:+.2e} m/s", block.v);
        assert_eq!(block.v < -1e-3, turns);
    }
}

#[test]
fn held_force_is_what_the_bristles_carry() {
    for (law, z) in [(Law::Dahl(dahl()), 1.5), (Law::LuGre(lugre()), 1.5)] {
        let mut block = Block::new(law, MASS, DT);
        for k in 0..20_000 {
            block.push(z * (k as f64 * DT).min(1.0));
        }
        assert!(close(block.friction, z, 1e-6), "{} carries {}", law.id(), block.friction);
    }
}
