//! Equal parameters, mirrored motion, mirrored force, to the last bit; and swapped parameters alike.

use crate::common::{coulomb, dahl, laws, rubber, surface, symmetric_laws};
use friction::{FrictionLaw, Law, LawKind, Motion, Surface};
use proptest::prelude::*;

fn motions() -> impl Strategy<Value = Vec<Motion<f64>>> {
    let one =
        (-0.2..0.2_f64, -10.0..10.0_f64, prop::sample::select(vec![0.0, 0.419]), prop::bool::weighted(0.2));
    prop::collection::vec(one, 1..60).prop_map(|steps| {
        let mut position = 0.0;
        steps
            .into_iter()
            .map(|(velocity, applied, mass, at_rest)| {
                let velocity = if at_rest { 0.0 } else { velocity * velocity * velocity * 25.0 };
                position += velocity * 1e-3;
                Motion {
                    dt: 1e-3,
                    position,
                    displacement: velocity * 1e-3,
                    velocity,
                    applied,
                    mass,
                    normal: None,
                }
            })
            .collect()
    })
}

fn mirrored(m: &Motion<f64>) -> Motion<f64> {
    Motion {
        position: -m.position,
        displacement: -m.displacement,
        velocity: -m.velocity,
        applied: -m.applied,
        ..*m
    }
}

fn swapped(law: &Law<f64>) -> Law<f64> {
    let s = Surface::of(law);
    let other = Surface {
        static_p: s.static_n,
        static_n: s.static_p,
        dynamic_p: s.dynamic_n,
        dynamic_n: s.dynamic_p,
        damping_p: s.damping_n,
        damping_n: s.damping_p,
        ..s
    };
    other.law(law.kind())
}

fn agree(law: &Law<f64>, mirror: &Law<f64>, motions: &[Motion<f64>]) -> Result<(), TestCaseError> {
    let (mut a, mut b) = (Default::default(), Default::default());
    for motion in motions {
        let (f, g) = (law.step(&mut a, motion), mirror.step(&mut b, &mirrored(motion)));
        prop_assert_eq!(f, -g, "{} at {:?}", law.id(), motion);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn odd_where_parameters_are_symmetric(motions in motions()) {
        for law in symmetric_laws() {
            agree(&law, &law, &motions)?;
        }
    }

    #[test]
    fn the_other_direction_has_the_other_parameters(motions in motions()) {
        for (law, ..) in laws() {
            agree(&law, &swapped(&law), &motions)?;
        }
    }

    /// The enum is the law in it.
    #[test]
    fn law_chosen_at_run_time_is_the_law(motions in motions()) {
        let (mut any, mut own) = (Default::default(), Default::default());
        for motion in &motions {
            prop_assert_eq!(Law::Dahl(dahl()).step(&mut any, motion), dahl().step(&mut own, motion));
        }
        let (mut any, mut own) = (Default::default(), Default::default());
        for motion in &motions {
            prop_assert_eq!(Law::Coulomb(coulomb()).step(&mut any, motion), coulomb().step(&mut own, motion));
            prop_assert_eq!(Law::Karnopp(rubber()).step(&mut Default::default(), motion), rubber().step(&mut (), motion));
        }
    }
}

#[test]
fn a_law_that_meets_anothers_memory_starts_fresh() {
    let motion = Motion { dt: 1e-3, displacement: 1e-5, velocity: 0.01, ..Motion::default() };
    let mut state = Default::default();
    for _ in 0..100 {
        Law::LuGre(crate::common::lugre()).step(&mut state, &motion);
    }
    let mut fresh = Default::default();
    assert_eq!(Law::Dahl(dahl()).step(&mut state, &motion), Law::Dahl(dahl()).step(&mut fresh, &motion));
    assert_eq!(state, fresh);
}

#[test]
fn ids_are_those_of_files() {
    let ids: Vec<&str> = LawKind::ALL.iter().map(|law| law.id()).collect();
    assert_eq!(LawKind::IDS, ids.join(", "));
    let (mut known, mut own): (Vec<&str>, _) = (friction::LAWS.iter().map(|(id, _)| *id).collect(), ids);
    known.sort_unstable();
    own.sort_unstable();
    assert_eq!(known, own);
    for kind in LawKind::ALL {
        let law = surface().law(*kind);
        let text = serde_json::to_string(&law).expect("a law is written");
        assert!(text.starts_with(&format!("{{\"{}\":", law.id())), "{text}");
        let back: Law<f64> = serde_json::from_str(&text).expect("and read");
        assert_eq!(back, law);
    }
}
