//! Invalid input: the rig stays finite and counts it.

use friction::{Custom, Motion};
use plant::{Coupling, HandImpedance, NoHand, Rig, RigConfig, Target};
use proptest::prelude::*;

fn any_force() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -20.0..20.0f64,
        1 => prop::num::f64::ANY,
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -0.0, 5e-324]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn stays_finite(
        commands in prop::collection::vec(any_force(), 50..200),
        hand in prop::collection::vec(any_force(), 50),
        poison in any_force(),
        compliant in any::<bool>(),
        stroke in any::<bool>(),
        limit in any::<bool>(),
        jitter in 0.0..1e5f64,
        seed in any::<u64>(),
    ) {
        let config = RigConfig {
            coupling: if compliant {
                Coupling::Compliant { stiffness: 4e5, damping: 30.0 }
            } else {
                Coupling::Rigid
            },
            stroke: stroke.then_some(0.032),
            force_max: limit.then_some(9.48),
            clock_jitter_ticks: jitter,
            ..RigConfig::default()
        };
        // a law that is NaN beyond 1 mm
        let law = Custom(move |m: &Motion<f64>| {
            if m.position > 1e-3 { poison } else { (m.applied + m.mass * m.velocity / m.dt).clamp(-2.0, 2.0) }
        });
        let mut rig = Rig::new(config, law, seed).unwrap();
        let mut calls = 0;
        let mut bad = commands.iter().any(|c| !c.is_finite());
        for command in &commands {
            rig.tick(*command, &mut |_t: f64, _x: f64, _v: f64| {
                calls += 1;
                let force = hand[calls % hand.len()];
                bad |= !force.is_finite();
                force
            });
            let t = rig.truth();
            for value in [t.time, t.position, t.velocity, t.acceleration, t.block_position, t.block_velocity,
                t.force_at_load_cell, t.friction, t.hand_force, t.friction_work, t.hand_work]
            {
                prop_assert!(value.is_finite(), "{t:?}");
            }
        }
        prop_assert!(!bad || rig.truth().not_finite > 0);
    }

    #[test]
    fn friction_alone_never_gains_energy(
        speed in -0.5..0.5f64,
        level_p in 0.0..5.0f64,
        level_n in 0.0..5.0f64,
        viscous in 0.0..50.0f64,
        substeps in 10..40u32,
    ) {
        let config = RigConfig {
            device_damping: 0.0, device_friction_p: 0.0, device_friction_n: 0.0, stroke: None, substeps,
            actuation_delay: 0, force_max: None,
            ..RigConfig::default()
        };
        let law = Custom(move |m: &Motion<f64>| {
            let slides = if m.velocity > 0.0 { level_p } else if m.velocity < 0.0 { -level_n } else { 0.0 };
            slides + viscous * m.velocity
        });
        let mut rig = Rig::new(config, law, 1).unwrap();
        // pushed for one period, then free
        rig.tick(speed * (0.692 + 0.419) * 1e3, &mut NoHand);
        let mut last = rig.truth().velocity.abs();
        let direction = rig.truth().velocity.signum();
        for _ in 0..300 {
            rig.tick(0.0, &mut NoHand);
            let v = rig.truth().velocity;
            prop_assert!(v.abs() <= last, "{} > {}", v.abs(), last);
            prop_assert!(v == 0.0 || v.signum() == direction);
            last = v.abs();
        }
    }
}

#[test]
fn a_hand_of_nan_is_counted() {
    let mut rig = Rig::new(RigConfig::default(), Custom(|_: &Motion<f64>| 0.0), 1).unwrap();
    let mut hand = HandImpedance {
        mass: f64::NAN,
        stiffness: f64::NAN,
        damping: 1.0,
        target: Target::Hold { position: 0.0 },
    };
    rig.tick(1.0, &mut hand);
    rig.tick(1.0, &mut hand);
    let t = rig.truth();
    println!("{} forces were not finite", t.not_finite);
    assert!(t.position.is_finite() && t.not_finite > 2);
}
