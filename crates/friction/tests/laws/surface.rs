//! One surface for every law, and what each law makes of it.

use crate::common::surface;
use friction::{BOTH_DIRECTIONS, FrictionLaw, Law, LawKind, MajdSimaan, Motion, Surface, parameters};

#[test]
fn a_law_gives_back_the_surface_that_it_was_made_of() {
    for kind in LawKind::ALL {
        let law = surface().law(*kind);
        law.validate().unwrap_or_else(|refused| panic!("{}: {refused}", kind.id()));
        let back = Surface::of(&law);
        for name in kind.parameters().iter().filter(|name| **name != "adhesion") {
            let known = Surface::<f64>::NAMES.contains(name) || BOTH_DIRECTIONS.contains(name);
            assert!(
                known && parameters::find(name).is_some(),
                "{}: `{name}` is not a parameter of Surface",
                kind.id()
            );
            let (told, given) = (back.get(name), surface().get(name));
            let near = told.zip(given).is_some_and(|(a, b)| (a - b).abs() <= 1e-9 * b.abs());
            assert!(near, "{}: {name} {told:?}, {given:?} was given", kind.id());
        }
        assert_eq!(back.law(*kind).kind(), *kind);
    }
}

/// Far beyond its presliding and its Stribeck velocity, each law is a level and a line.
#[test]
fn every_law_slides_at_its_dynamic_friction() {
    let of_surface = surface();
    for kind in LawKind::ALL {
        let (law, mut state) = (of_surface.law(*kind), Default::default());
        let mut force = |_| {
            let sliding = Motion { dt: 1e-3, displacement: 3e-4, velocity: 0.3, ..Motion::default() };
            law.step(&mut state, &sliding)
        };
        for k in 0..2_000 {
            force(k);
        }
        let mean = (0..2_000).map(force).sum::<f64>() / 2_000.0;
        // the classic law counts its viscous part from where friction has fallen
        let from = if *kind == LawKind::Classic { 0.3 - of_surface.stribeck_velocity } else { 0.3 };
        let level = if *kind == LawKind::Viscous { 0.0 } else { of_surface.dynamic_p };
        let expected = level + of_surface.damping_p * from;
        println!("{:17} {mean:.4} N, expected {expected:.4} N", kind.id());
        let tolerance = if *kind == LawKind::Bristle { 0.02 } else { 1e-6 };
        assert!((mean - expected).abs() <= tolerance * expected, "{}: {mean} N", kind.id());
    }
}

/// No law gives back more than it stored: the work done on it covers what its springs hold.
#[test]
fn the_energy_that_a_law_tells_was_put_into_it() {
    let from_rest = Surface { static_p: 3.0, static_n: 3.0, sigma_1: 0.0, ..surface() };
    for kind in LawKind::ALL {
        let (law, mut state) = (from_rest.law(*kind), Default::default());
        let (mut work, mut most, mut before) = (0.0, 0.0_f64, 0.0);
        for k in 0..40_000 {
            let t = f64::from(k) * 1e-4;
            let x = 4e-4 * (9.0 * t).sin() + 3e-5 * (140.0 * t).sin();
            let motion = Motion {
                dt: 1e-4,
                displacement: x - before,
                velocity: (x - before) * 1e4,
                ..Motion::default()
            };
            before = x;
            work += law.step(&mut state, &motion) * motion.displacement;
            let stored = law.stored(&state);
            most = most.max(stored);
            assert!(stored >= 0.0 && stored <= work + 1e-9, "{}: {stored} J of {work} J at {k}", kind.id());
        }
        println!("{:17} holds up to {most:.2e} J, {work:.2e} J went into it", kind.id());
        // F²/2σ of a spring at its level is 9e-5 J, of bonds half as much
        assert_eq!(most > 3e-5, kind.takes("sigma"), "{}: {most} J", kind.id());
    }
}

#[test]
fn single_precision_finds_the_same_continuous_curve() {
    let law = |stiction: f64| {
        let base =
            MajdSimaan { viscous: 2.0, coulomb: 3.0, stribeck: 0.0, critical_velocity: 0.1, steepness: 10.0 };
        base.with_stiction(stiction)
    };
    let narrow =
        MajdSimaan { viscous: 2.0_f32, coulomb: 3.0, stribeck: 0.0, critical_velocity: 0.1, steepness: 10.0 };
    for stiction in [3.0, 3.2, 4.0, 9.0] {
        let (wide, narrow) = (law(stiction), narrow.with_stiction(stiction as f32));
        assert!((wide.stiction() - stiction).abs() < 1e-9);
        assert!((f64::from(narrow.stribeck) - wide.stribeck).abs() < 1e-4 * (1.0 + wide.stribeck));
    }
}

#[test]
fn a_law_of_ones_own_stores_nothing() {
    let law = Law::Viscous(friction::Viscous { damping_p: 1.0, damping_n: 1.0 });
    assert_eq!(law.stored(&Default::default()), 0.0);
}
