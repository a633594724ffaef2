//! Coulomb friction stops a body exactly, in finite time, where it should; Karnopp only with a wide enough band.

use crate::common::{Block, MASS};
use friction::{Coulomb, Karnopp};

fn dry(level: f64) -> Coulomb<f64> {
    Coulomb {
        level_p: level,
        level_n: level,
        static_p: level,
        static_n: level,
        viscous_p: 0.0,
        viscous_n: 0.0,
    }
}

#[test]
fn coulomb_stopping_distance_matches_energy() {
    let (level, v0) = (3.0, 0.25);
    let a = level / MASS;
    for dt in [1e-5, 1e-4, 1e-3, 1e-2] {
        let mut block = Block::new(dry(level), MASS, dt);
        block.v = v0;
        let mut steps = 0;
        while block.state.sliding || steps == 0 {
            block.push(0.0);
            steps += 1;
        }
        let (rest, distance) = (block.v, v0 * v0 / (2.0 * a));
        let stopped = block.x;
        println!(
            "dt {dt:.0e} s: stops after {:.5} s (v/a = {:.5}) and {stopped:.6e} m (v²/2a = {distance:.6e}), v = {rest:e}",
            steps as f64 * dt,
            v0 / a
        );
        assert_eq!(steps, (v0 / a / dt).ceil() as usize);
        // semi-implicit Euler ends each step at its own velocity: half a step of v0 short
        assert!((stopped - (distance - 0.5 * v0 * dt)).abs() <= 0.125 * a * dt * dt + 1e-15);
        assert!(rest.abs() < 1e-16);
        for _ in 0..10_000 {
            block.push(0.0);
        }
        assert!((block.x - stopped).abs() < 1e-15, "it crept {}", block.x - stopped);
    }
}

#[test]
fn coulomb_has_no_limit_cycle() {
    for dt in [1e-4, 1e-3, 1e-2, 0.1, 1.0] {
        for mass in [1e-3, 0.419, 50.0] {
            let mut block = Block::new(dry(3.0), mass, dt);
            block.v = 0.3;
            let mut reversals = 0;
            for _ in 0..2000 {
                let before = block.v;
                block.push(2.0 * (1.0 - 1e-3)); // below the level, all the time
                reversals += usize::from(before * block.v < 0.0 && block.v.abs() > 1e-12);
            }
            assert_eq!(reversals, 0, "dt {dt}, mass {mass}");
            if dt * 1000.0 > mass {
                assert!(block.v.abs() < 1e-12, "dt {dt}, mass {mass}: still at {}", block.v);
            }
        }
    }
}

#[test]
fn karnopp_needs_half_a_step_of_velocity() {
    // A free mass jumps the band when C dt / m > 2 Δv, and then never stops.
    let (level, dt) = (3.0, 1e-3);
    let lost = level * dt / MASS;
    let swing = |share: f64| {
        let law = Karnopp {
            c_p: level,
            c_n: level,
            b_p: 0.0,
            b_n: 0.0,
            d_p: level,
            d_n: level,
            delta_v: share * lost,
        };
        let mut block = Block::new(law, MASS, dt);
        block.v = 0.1 - 0.1 % lost + 0.5 * lost; // comes down to exactly half of a step's loss
        for _ in 0..1000 {
            block.push(0.0);
        }
        block.v.abs()
    };
    println!(
        "Δv = 0.45 C dt/m: |v| = {:.3e} m/s for ever; Δv = 0.55 C dt/m: {:.1e}",
        swing(0.45),
        swing(0.55)
    );
    assert!(swing(0.45) > 0.4 * lost);
    assert!(swing(0.55) < 1e-15);
}

#[test]
fn coulomb_is_the_implicit_solution() {
    // m (v' − v)/dt = F_a − F with F in level·Sgn(v'): what Coulomb friction is, stated at the end of the step.
    for k in 0..1000 {
        let v = 0.05 * f64::sin(1.3 * k as f64);
        let applied = 6.0 * f64::cos(0.7 * k as f64);
        let mut block = Block::new(dry(3.0), MASS, 1e-3);
        block.v = v;
        block.state.sliding = true;
        block.push(applied);
        if block.v.abs() > 1e-15 {
            assert!((block.friction - 3.0 * block.v.signum()).abs() < 1e-12);
        } else {
            assert!(block.friction.abs() <= 3.0);
        }
    }
}
