//! The laws of `friction` under the rig's integrator.

use friction::effects::{Effect, EffectKind};
use friction::{Coulomb, Dahl, FrictionLaw, Karnopp, Law, LuGre};
use plant::materials::{BRASS, RUBBER};
use plant::{HandImpedance, Layered, NoHand, Rig, RigConfig, Target};

const KARNOPP: Karnopp<f64> = BRASS.law;
const COULOMB: Coulomb<f64> = Coulomb {
    level_p: 1.77,
    level_n: 1.73,
    static_p: 2.13,
    static_n: 1.86,
    viscous_p: 0.46,
    viscous_n: 0.62,
};
const DAHL: Dahl<f64> =
    Dahl { limit_p: 1.9078, limit_n: 1.7296, sigma: 30_000.0, exponent: 1.0, viscous: 2.0 };
const LUGRE: LuGre<f64> = LuGre {
    sigma_0: 50_000.0,
    sigma_1: 100.0,
    sigma_2: 30.0,
    coulomb: 1.7,
    stiction: 2.1,
    stribeck_velocity: 0.005,
};

fn rig<L: FrictionLaw<f64>>(law: L) -> Rig<L> {
    let config = RigConfig { device_friction_p: 0.0, device_friction_n: 0.0, ..RigConfig::noiseless() };
    Rig::new(config, law, 1).unwrap()
}

/// A stiff hand that moves the handle at a given speed from 1 cm behind the middle.
fn dragged(velocity: f64) -> (HandImpedance, f64) {
    let start = -0.01f64.copysign(velocity);
    (
        HandImpedance { mass: 0.0, stiffness: 2e4, damping: 200.0, target: Target::Ramp { start, velocity } },
        start,
    )
}

#[test]
fn every_law_holds_below_break_away_for_ten_seconds() {
    for (law, elastic) in [
        (Law::Karnopp(KARNOPP), 0.0),
        (Law::Coulomb(COULOMB), 0.0),
        // Dahl, i = 1: x = −(D/σ)·ln(1 − F/D); LuGre: bristles bend by F/σ₀ and a little more
        (Law::Dahl(DAHL), -(1.9078 / 30_000.0) * (1.0f64 - 1.2 / 1.9078).ln()),
        (Law::LuGre(LUGRE), -(2.1 / 50_000.0) * (1.0f64 - 1.2 / 2.1).ln()),
    ] {
        let mut rig = rig(law);
        let mut settled = 0.0;
        // without a damping hand the steps of the ramp shake the contact, and Dahl drifts when shaken
        let mut calm = HandImpedance {
            mass: 0.0,
            stiffness: 0.0,
            damping: 300.0,
            target: Target::Hold { position: 0.0 },
        };
        for k in 0..10_000u32 {
            // a ramp without overshoot, then constant 1.2 N
            rig.tick(1.2 * (f64::from(k) / 2000.0).min(1.0), &mut calm);
            if k == 3000 {
                settled = rig.truth().position;
            }
        }
        let t = rig.truth();
        println!(
            "{}: settles {:.4e} m away (closed form {elastic:.4e}), creeps {:.1e} m in 7 s, v = {:.1e} m/s",
            law.id(),
            settled,
            t.position - settled,
            t.velocity
        );
        if elastic == 0.0 {
            assert_eq!((t.position, t.velocity), (0.0, 0.0));
            assert!(t.stuck);
        } else {
            assert!((settled / elastic - 1.0).abs() < 0.02);
            assert!((t.position - settled).abs() < 1e-9);
        }
    }
}

#[test]
fn steady_sliding_matches_each_law() {
    for speed in [0.03, -0.03] {
        for (law, expected) in [
            (
                Law::Karnopp(KARNOPP),
                if speed > 0.0 { 1.7714 + 0.457 * speed } else { -1.729 + 0.6196 * speed },
            ),
            (Law::Coulomb(COULOMB), if speed > 0.0 { 1.77 + 0.46 * speed } else { -1.73 + 0.62 * speed }),
            (Law::Dahl(DAHL), if speed > 0.0 { 1.9078 + 2.0 * speed } else { -1.7296 + 2.0 * speed }),
            (Law::LuGre(LUGRE), LUGRE.level(speed).copysign(speed) + 30.0 * speed),
        ] {
            let mut rig = rig(law);
            let (mut hand, _) = dragged(speed);
            for _ in 0..500 {
                rig.tick(0.0, &mut hand);
            }
            let t = rig.truth();
            println!("{} at {:.4} m/s: {:.6} N, closed form {expected:.6}", law.id(), t.velocity, t.friction);
            assert!((t.velocity - speed).abs() < 1e-6 && (t.friction - expected).abs() < 1e-4);
            assert!((t.force_at_load_cell - t.friction).abs() < 1e-2);
        }
    }
}

#[test]
fn slow_pull_through_a_spring_sticks_and_slips() {
    // 5 mm/s through 400 N/m, below Δv of brass: the load rises to D_p, breaks away, overshoots, sticks again
    let mut rig = rig(KARNOPP);
    let mut hand = HandImpedance {
        mass: 0.0,
        stiffness: 400.0,
        damping: 0.0,
        target: Target::Ramp { start: -0.01, velocity: 0.005 },
    };
    let config = RigConfig { start_position: -0.01, ..*rig.config() };
    rig.reconfigure(config).unwrap();
    rig.reset();
    let (mut break_aways, mut held, mut last) = (Vec::new(), 0, rig.truth());
    for _ in 0..4000 {
        rig.tick(0.0, &mut hand);
        let t = rig.truth();
        if last.stuck && last.time > 0.0 {
            held += 1;
            assert_eq!(last.velocity, 0.0);
            if !t.stuck {
                break_aways.push(last.force_at_load_cell);
            }
        }
        last = t;
    }
    println!(
        "{} slips, stuck {:.0} % of the time, breaks away at {break_aways:.3?} N",
        break_aways.len(),
        f64::from(held) / 40.0
    );
    assert!(break_aways.len() >= 3 && held > 1000);
    // the load rises by 2 mN a period
    assert!(break_aways.iter().all(|f| (f - KARNOPP.d_p).abs() < 4e-3));
}

#[test]
fn a_released_block_comes_to_rest_without_energy_gain() {
    for law in [Law::Karnopp(RUBBER.law), Law::Coulomb(COULOMB), Law::Dahl(DAHL), Law::LuGre(LUGRE)] {
        let mut rig = rig(law);
        for _ in 0..50 {
            rig.tick(6.0, &mut NoHand);
        }
        rig.tick(0.0, &mut NoHand);
        let mass = 0.692 + 0.419;
        let kinetic = |t: plant::Truth| 0.5 * mass * t.velocity * t.velocity;
        // a law with a spring stores at most D²/2σ
        let start = kinetic(rig.truth());
        let spring = 2.1f64.powi(2) / (2.0 * 30_000.0);
        let mut worst = 0.0f64;
        for _ in 0..3000 {
            let before = rig.truth();
            rig.tick(0.0, &mut NoHand);
            worst = worst.max(kinetic(rig.truth()) - kinetic(before));
        }
        let t = rig.truth();
        println!(
            "{}: {start:.4} J at release, largest rise {worst:.1e} J (spring {spring:.1e} J), ends at {:.1e} m/s",
            law.id(),
            t.velocity
        );
        assert!(worst <= spring && t.velocity.abs() < 1e-6);
        if matches!(law, Law::Karnopp(_) | Law::Coulomb(_)) {
            assert_eq!((worst, t.velocity), (0.0, 0.0));
        }
    }
}

fn effect(id: &str, values: &[(&str, f64)]) -> Effect<f64> {
    let kind = EffectKind::from_id(id).unwrap();
    let mut effect = Effect {
        kind,
        gains: [0.0; friction::effects::MAX_GAINS],
        shape: [0.0; friction::effects::MAX_SHAPE],
    };
    for parameter in kind.gains().iter().chain(kind.shape()) {
        // a value inside the range for parameters without a given value
        *effect.get_mut(parameter.name).unwrap() = parameter.min.max(0.0);
    }
    for (name, value) in values {
        *effect.get_mut(name).unwrap_or_else(|| panic!("{id} has no {name}")) = *value;
    }
    effect
}

#[test]
fn stiction_holds_an_added_spring() {
    let spring = effect("spring", &[(EffectKind::from_id("spring").unwrap().gains()[0].name, 100.0)]);
    let law = Layered::with(KARNOPP, &[spring]).unwrap();
    let mut rig = rig(law);
    let (mut hand, _) = dragged(0.05);
    for _ in 0..400 {
        rig.tick(0.0, &mut hand);
    }
    let t = rig.truth();
    let expected = 1.7714 + 0.457 * t.velocity + 100.0 * t.position;
    println!(
        "at {:.3} mm and {:.3} m/s: {:.4} N, closed form {expected:.4}",
        t.position * 1e3,
        t.velocity,
        t.friction
    );
    assert!((t.friction - expected).abs() < 1e-9);
    // let go at 10 mm: 1 N of spring against 1.86 N of stiction. It stays.
    while rig.truth().velocity != 0.0 {
        rig.tick(0.0, &mut NoHand);
    }
    let rest = rig.truth().position;
    for _ in 0..5000 {
        rig.tick(0.0, &mut NoHand);
    }
    println!("held at {:.3} mm by stiction against {:.3} N of spring", rest * 1e3, 100.0 * rest);
    assert!(rest > 5e-3 && rig.truth().position == rest && rig.truth().friction == 0.0);
}

#[test]
fn every_effect_of_the_catalogue_runs_in_the_rig() {
    for kind in EffectKind::ALL {
        let mut one = effect(kind.id(), &[]);
        for (k, parameter) in kind.gains().iter().enumerate() {
            one.gains[k] = 0.3f64.clamp(parameter.min, parameter.max);
        }
        for (k, parameter) in kind.shape().iter().enumerate() {
            one.shape[k] = 0.01f64.clamp(parameter.min, parameter.max);
        }
        if let Err(refused) = one.validate() {
            panic!("{}: {refused}", kind.id());
        }
        let mut rig = rig(Layered::with(KARNOPP, &[one]).unwrap());
        let mut hand = HandImpedance::relaxed(Target::Sine { centre: 0.0, amplitude: 0.008, frequency: 2.0 });
        hand.stiffness = 3000.0;
        hand.damping = 30.0;
        let mut furthest = 0.0f64;
        for _ in 0..2000 {
            rig.tick(0.0, &mut hand);
            furthest = furthest.max(rig.truth().position.abs());
        }
        println!("{:28} moved {:.2} mm", kind.id(), furthest * 1e3);
        assert!(rig.truth().not_finite == 0 && furthest > 1e-3 && furthest < 0.02);
    }
}

#[test]
fn load_dependent_friction_sees_the_force_on_the_block() {
    // friction = μ·N + share·|force at the load cell|, on a block that is accelerated
    let load = effect("load_dependent_friction", &[("mu", 0.2), ("share", 0.3)]);
    let base = Karnopp { c_p: 0.0, c_n: 0.0, b_p: 0.0, b_n: 0.0, d_p: 0.0, d_n: 0.0, delta_v: 0.0 };
    let mut law = Layered::with(base, &[load]).unwrap();
    law.block_mass = Some(0.419);
    let mut rig = rig(law);
    for _ in 0..20 {
        rig.tick(7.0, &mut NoHand);
    }
    let t = rig.truth();
    let expected = 0.2 * 0.419 * 9.80665 + 0.3 * t.force_at_load_cell.abs();
    println!(
        "a {:.3} m/s², load cell {:.4} N, friction {:.4} N, closed form {expected:.4}",
        t.acceleration, t.force_at_load_cell, t.friction
    );
    assert!(t.acceleration > 1.0 && (t.friction - expected).abs() < 1e-3);
}

#[test]
fn a_spring_in_a_law_conserves_energy() {
    let spring = effect("spring", &[("stiffness", 2000.0)]);
    let base = Karnopp { c_p: 0.0, c_n: 0.0, b_p: 0.0, b_n: 0.0, d_p: 0.0, d_n: 0.0, delta_v: 0.0 };
    let mut rig = rig(Layered::with(base, &[spring]).unwrap());
    rig.reconfigure(RigConfig { device_damping: 0.0, start_position: 0.005, ..*rig.config() }).unwrap();
    rig.reset();
    let energy = |t: plant::Truth| 0.5 * (0.692 + 0.419) * t.velocity.powi(2) + 1000.0 * t.position.powi(2);
    let start = energy(rig.truth());
    let worst = (0..10_000)
        .map(|_| {
            rig.tick(0.0, &mut NoHand);
            (energy(rig.truth()) / start - 1.0).abs()
        })
        .fold(0.0, f64::max);
    println!("energy within {worst:.1e} of {start:.4} J over 10 s, 67 swings");
    assert!(worst < 1e-3);
}

#[test]
fn too_many_effects_are_refused() {
    let offset = effect("offset", &[]);
    let refused = Layered::with(KARNOPP, &[offset; plant::MAX_EFFECTS + 1]).unwrap_err();
    println!("{refused}");
    assert_eq!(refused.parameter, "effects");
}
