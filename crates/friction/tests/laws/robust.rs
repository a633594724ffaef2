//! Any motion at all: bounded, finite for finite input, and one bad sample does not last.

use crate::common::{dahl, laws, lugre, rubber};
use friction::effects::{Effect, EffectKind, EffectState};
use friction::{Adhesion, Coulomb, Dahl, FrictionLaw, Karnopp, Law, LawKind, LuGre, Motion, Surface};
use proptest::num;
use proptest::prelude::*;

fn any_finite() -> impl Strategy<Value = f32> {
    prop_oneof![1 => num::f32::NORMAL | num::f32::SUBNORMAL | num::f32::ZERO, 1 => -1.0..1.0_f32]
}

fn any_motion() -> impl Strategy<Value = Motion<f32>> {
    let dt = prop::sample::select(vec![0.0, f32::from_bits(1), 1e-30, 1e-6, 1e-3, 1.0, f32::MAX, -1.0]);
    let mass = prop::sample::select(vec![0.0, f32::from_bits(1), 0.4, 1e3, f32::MAX, -1.0]);
    (dt, mass, any_finite(), any_finite(), any_finite(), any_finite(), prop::option::of(any_finite()))
        .prop_map(|(dt, mass, position, displacement, velocity, applied, normal)| Motion {
            dt,
            position,
            displacement,
            velocity,
            applied,
            mass,
            normal,
        })
}

/// Any valid parameters, the extremes more often than chance would.
fn level() -> impl Strategy<Value = f32> {
    prop_oneof![0.0..10.0_f32, Just(0.0), Just(f32::from_bits(1)), Just(1e6)]
}

fn viscous() -> impl Strategy<Value = f32> {
    prop_oneof![-10.0..100.0_f32, Just(0.0), Just(-1e6), Just(1e6)]
}

fn any_law() -> impl Strategy<Value = Law<f32>> {
    let karnopp = (level(), level(), viscous(), viscous(), level(), level(), 0.0..10.0_f32).prop_map(
        |(c_p, c_n, b_p, b_n, d_p, d_n, delta_v)| {
            Law::Karnopp(Karnopp { c_p, c_n, b_p, b_n, d_p, d_n, delta_v })
        },
    );
    let coulomb = (level(), level(), level(), level(), viscous(), viscous()).prop_map(
        |(level_p, level_n, more_p, more_n, viscous_p, viscous_n)| {
            Law::Coulomb(Coulomb {
                level_p,
                level_n,
                static_p: level_p.max(more_p),
                static_n: level_n.max(more_n),
                viscous_p,
                viscous_n,
            })
        },
    );
    let sigma = || prop_oneof![1.0..1e6_f32, Just(1e-3), Just(1e12)];
    let exponent = prop_oneof![Just(1.0), Just(0.0), 0.0..10.0_f32, 0.999..1.001_f32];
    let dahl = (level(), level(), sigma(), exponent, viscous()).prop_map(
        |(limit_p, limit_n, sigma, exponent, viscous)| {
            Law::Dahl(Dahl { limit_p, limit_n, sigma, exponent, viscous })
        },
    );
    let lugre = (sigma(), 0.0..1e6_f32, 0.0..1e6_f32, level(), level(), 1e-6..1e3_f32).prop_map(
        |(sigma_0, sigma_1, sigma_2, coulomb, more, stribeck_velocity)| {
            Law::LuGre(LuGre {
                sigma_0,
                sigma_1,
                sigma_2,
                coulomb,
                stiction: coulomb.max(more),
                stribeck_velocity,
            })
        },
    );
    let numbers = (level(), level(), 0.0..1e6_f32, 1.0..1e6_f32, 1e-6..1e3_f32, 0.0..1.0_f32);
    let others =
        (4..LawKind::ALL.len(), numbers).prop_map(|(kind, (level, more, damping, sigma, speed, share))| {
            let stiction = level.max(more);
            let surface = Surface {
                static_p: stiction,
                static_n: stiction,
                dynamic_p: level,
                dynamic_n: level,
                damping_p: damping,
                damping_n: damping,
                dv: speed,
                sigma,
                stribeck_velocity: speed,
                elastic: 0.99 * share,
                attraction: 1e6 * share,
                memory: share,
                dwell: 1e-6 + share,
                steepness: 1.1 + 100.0 * share,
                adhesion: Adhesion::ALL[(2.99 * share) as usize].1,
                ..Surface::default()
            };
            surface.law(LawKind::ALL[kind])
        });
    prop_oneof![1 => karnopp, 1 => coulomb, 1 => dahl, 1 => lugre, 4 => others]
}

fn any_effect() -> impl Strategy<Value = Effect<f32>> {
    (0..EffectKind::ALL.len(), prop::array::uniform4(0.0..=1.0_f64), prop::array::uniform2(0.0..=1.0_f64))
        .prop_map(|(which, gains, shape)| {
            let kind = EffectKind::ALL[which];
            let mut effect = Effect { kind, gains: [0.0; 4], shape: [0.0; 2] };
            for ((gain, share), p) in effect.gains.iter_mut().zip(gains).zip(kind.gains()) {
                *gain = (p.min + (p.max - p.min) * share) as f32;
            }
            for ((value, share), p) in effect.shape.iter_mut().zip(shape).zip(kind.shape()) {
                *value = ((p.min + (p.max - p.min) * share) as f32).clamp(p.min as f32, p.max as f32);
            }
            effect
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn forces_are_finite_and_bounded(law in any_law(), motions in prop::collection::vec(any_motion(), 1..8)) {
        prop_assert!(law.validate().is_ok());
        let mut state = Default::default();
        for motion in &motions {
            let force = law.step(&mut state, motion);
            prop_assert!(force.is_finite(), "{law:?} gives {force} at {motion:?}");
            let v = f64::from(motion.velocity.abs());
            let bound = match law {
                Law::Karnopp(k) => f64::from(k.d_p.max(k.d_n).max(k.c_p).max(k.c_n)) + f64::from(k.b_p.max(k.b_n).max(0.0)) * v,
                Law::Coulomb(c) => f64::from(c.static_p.max(c.static_n)) + f64::from(c.viscous_p.max(c.viscous_n).max(0.0)) * v,
                Law::Dahl(d) => f64::from(d.limit_p.max(d.limit_n)) + f64::from(d.viscous.abs()) * v,
                // bristle damping is bounded by what the bristles can travel in the step
                Law::LuGre(l) if motion.dt > 0.0 => f64::from(l.stiction) + f64::from(l.sigma_2) * v
                    + f64::from(l.sigma_1) * 2.0 * f64::from(l.stiction) / f64::from(l.sigma_0) / f64::from(motion.dt),
                Law::LuGre(l) => f64::from(l.stiction) + f64::from(l.sigma_2) * v,
                other => {
                    let s = Surface::of(&other);
                    // a fresh contact of bristles breaks away at 1.5 times its level
                    1.5 * f64::from(s.static_p.max(s.dynamic_p)) * (1.0 + 1e-4) + f64::from(s.damping_p.max(s.damping_n)) * v
                }
            };
            prop_assert!(f64::from(force.abs()) <= bound * (1.0 + 1e-6), "{law:?}: {force} N over {bound} N at {motion:?}");
            if let (Law::Dahl(d), friction::LawState::Dahl(s)) = (&law, &state) {
                prop_assert!(s.z <= d.limit_p && s.z >= -d.limit_n);
            }
            if let (Law::LuGre(l), friction::LawState::LuGre(s)) = (&law, &state) {
                prop_assert!(s.z.abs() <= l.stiction / l.sigma_0 * (1.0 + 1e-6));
            }
        }
    }

    #[test]
    fn effects_are_finite(effect in any_effect(), motions in prop::collection::vec(any_motion(), 1..8)) {
        let mut state = EffectState::default();
        for motion in &motions {
            let force = effect.step(&mut state, motion);
            prop_assert!(force.is_finite(), "{effect:?} gives {force} at {motion:?}");
        }
    }
}

/// Every motion with one number that is not finite.
fn bad_motions() -> Vec<Motion<f64>> {
    let good = Motion {
        dt: 1e-3,
        position: 0.01,
        displacement: 1e-5,
        velocity: 0.01,
        applied: 1.0,
        mass: 0.4,
        normal: Some(4.0),
    };
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY]
        .into_iter()
        .flat_map(|bad| {
            [
                Motion { dt: bad, ..good },
                Motion { position: bad, ..good },
                Motion { displacement: bad, ..good },
                Motion { velocity: bad, ..good },
                Motion { applied: bad, ..good },
                Motion { mass: bad, ..good },
                Motion { normal: Some(bad), ..good },
            ]
        })
        .collect()
}

#[test]
fn one_bad_sample_shows_and_does_not_last() {
    let good = Motion { dt: 1e-3, displacement: 1e-5, velocity: 0.01, applied: 1.0, ..Motion::default() };
    for (law, ..) in laws() {
        let mut state = Default::default();
        law.step(&mut state, &good);
        for bad in bad_motions() {
            let before = state;
            assert!(law.step(&mut state, &bad).is_nan(), "{} hides {bad:?}", law.id());
            if law.id() != "karnopp" {
                assert_eq!(state, before);
            }
        }
        assert!(law.step(&mut state, &good).is_finite());
    }
    for &kind in EffectKind::ALL {
        let mut memory = [0.0; 4];
        kind.unit(&[0.01, -0.01], &mut memory, &good);
        let before = memory;
        for bad in bad_motions() {
            assert!(kind.unit(&[0.01, -0.01], &mut memory, &bad).iter().all(|unit| unit.is_nan()));
            assert_eq!(memory, before);
        }
    }
}

#[test]
fn swapped_presets_limit_the_state() {
    let motion = Motion { dt: 1e-3, displacement: 1.0, velocity: 1.0, ..Motion::default() };
    let mut state = Default::default();
    dahl().step(&mut state, &motion);
    let weak = Dahl { limit_p: 0.5, limit_n: 0.5, viscous: 0.0, ..dahl() };
    assert_eq!(weak.step(&mut state, &Motion { dt: 1e-3, ..Motion::default() }), 0.5);
    let mut state = Default::default();
    lugre().step(&mut state, &motion);
    let weak = LuGre { coulomb: 0.5, stiction: 0.5, ..lugre() };
    let held = weak.step(&mut state, &Motion { dt: 1e-3, ..Motion::default() });
    assert!((held - 0.5).abs() < 1e-12);
}

#[test]
fn laws_without_friction_give_none() {
    let m = |v: f64| Motion {
        dt: 1e-3,
        displacement: v * 1e-3,
        velocity: v,
        applied: 1.0,
        mass: 0.4,
        ..Motion::default()
    };
    for v in [-1.0, -1e-3, 0.0, 1e-3, 1.0] {
        let k = Karnopp { c_p: 0.0, c_n: 0.0, b_p: 0.0, b_n: 0.0, d_p: 0.0, d_n: 0.0, ..rubber() };
        assert_eq!(k.step(&mut (), &m(v)), 0.0);
        let c = Coulomb {
            level_p: 0.0,
            level_n: 0.0,
            static_p: 0.0,
            static_n: 0.0,
            viscous_p: 0.0,
            viscous_n: 0.0,
        };
        assert_eq!(c.step(&mut Default::default(), &m(v)), 0.0);
        let d = Dahl { limit_p: 0.0, limit_n: 0.0, viscous: 0.0, ..dahl() };
        assert_eq!(d.step(&mut Default::default(), &m(v)), 0.0);
        let l = LuGre { coulomb: 0.0, stiction: 0.0, sigma_2: 0.0, ..lugre() };
        assert_eq!(l.step(&mut Default::default(), &m(v)), 0.0);
    }
}

#[test]
fn a_contact_that_slid_far_within_no_time_keeps_its_age() {
    // 7.8e12·(1 − 1.0000001) was below zero, and its logarithm no number
    let rock = Effect { kind: EffectKind::RateAndState, gains: [0.0; 4], shape: [1e-9, 0.742_046_54] };
    let mut state = EffectState::default();
    for (dt, displacement) in [(1e-30, 0.0), (1e-45, 110_462_010.0)] {
        let force: f32 = rock.step(&mut state, &Motion { dt, displacement, ..Motion::default() });
        assert_eq!(force, 0.0, "after {displacement} m in {dt} s");
    }
}
