//! No energy gained: over a closed path, in a free vibration, or at any moment beyond what the bristles store.

use crate::common::{Block, MASS, along, coulomb, dahl, laws, lugre, rubber};
use friction::{Dahl, FrictionLaw, Law, LuGre};
use proptest::prelude::*;

/// ∫F dx by the trapezoidal rule.
fn work(path: &[f64], forces: &[f64]) -> f64 {
    path.windows(2).zip(forces.windows(2)).map(|(x, f)| 0.5 * (f[0] + f[1]) * (x[1] - x[0])).sum()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// A body is led around any closed path: it takes work, in every law.
    #[test]
    fn no_energy_over_a_closed_path(
        amplitudes in prop::array::uniform4(-3e-4..3e-4_f64),
        phases in prop::array::uniform4(0.0..6.0_f64),
        dt in prop::sample::select(vec![1e-5, 1e-4, 1e-3]),
    ) {
        const N: usize = 2000;
        let cycle: Vec<f64> = (0..N)
            .map(|k| {
                (0..4).map(|h| {
                    let turn = core::f64::consts::TAU * k as f64 / N as f64;
                    amplitudes[h] * f64::sin((h + 1) as f64 * turn + phases[h])
                }).sum()
            })
            .collect();
        for (law, ..) in laws() {
            let mut state = Default::default();
            let path: Vec<f64> = (0..=12 * N).map(|k| cycle[k % N]).collect();
            let forces = along(&law, &mut state, &path, dt);
            // the last whole cycle, when what the bristles store is what it was a cycle before
            let done = work(&path[11 * N - 1..12 * N], &forces[11 * N - 2..12 * N - 1]);
            prop_assert!(done >= -1e-12, "{}: {done} J", law.id());
        }
    }

    /// With a known mass, a stopping force never adds to the velocity the step ends with.
    #[test]
    fn coulomb_opposes_the_end_of_every_step(
        v in -1.0..1.0_f64, applied in -20.0..20.0_f64, mass in 1e-3..10.0_f64, dt in 1e-5..1e-1_f64, sliding: bool,
    ) {
        let mut block = Block::new(coulomb(), mass, dt);
        block.v = v;
        block.state.sliding = sliding;
        block.push(applied);
        prop_assert!(block.friction * block.v >= -1e-12);
    }
}

#[test]
fn free_vibration_dies_out() {
    // block on a spring: energy, with what the bristles store, falls from peak to peak
    for (law, ..) in laws() {
        let (stiffness, dt) = (400.0, 1e-4);
        let mut block = Block::new(law, MASS, dt);
        block.x = 0.03;
        let mut last = 0.5 * stiffness * block.x * block.x;
        let (first, mut peaks) = (last, 0);
        let mut before = 0.0;
        for _ in 0..20_000 {
            block.push(-stiffness * block.x);
            if before * block.v < 0.0 {
                let energy = 0.5 * stiffness * block.x * block.x;
                // what Dahl's and LuGre's bristles hold at a peak is below D²/2σ = 0.12 mJ
                assert!(energy <= last + 1.2e-4, "{}: {energy} J after {last} J", law.id());
                last = energy;
                peaks += 1;
            }
            before = block.v;
        }
        println!("{:8} {first:.3} J at first, {last:.2e} J after {peaks} peaks", law.id());
        assert!(last < 0.1 * first && block.v.abs() < 1e-3);
    }
}

#[test]
fn vibration_about_rest_loses_what_coulomb_friction_takes() {
    // amplitude falls by 2 C/k each half cycle, until the spring can no longer break the contact away
    let law = friction::Coulomb {
        viscous_p: 0.0,
        viscous_n: 0.0,
        level_n: 3.0,
        level_p: 3.0,
        static_p: 3.0,
        static_n: 3.0,
    };
    let (stiffness, dt, x0) = (400.0, 1e-5, 0.1);
    let mut block = Block::new(law, MASS, dt);
    block.x = x0;
    let mut peaks = vec![];
    let mut before = 0.0;
    for _ in 0..500_000 {
        block.push(-stiffness * block.x);
        if before != 0.0 && before * block.v <= 0.0 {
            peaks.push(block.x.abs());
        }
        before = block.v;
        if !block.state.sliding && block.x.abs() * stiffness < 3.0 {
            break;
        }
    }
    for (k, peak) in peaks.iter().enumerate() {
        let expected = x0 - 2.0 * 3.0 / stiffness * (k + 1) as f64;
        println!("peak {k}: {peak:.5} m, expected {:.5} m", expected.abs());
        assert!((peak - expected.abs()).abs() < 2e-5);
    }
    assert_eq!(peaks.len(), 6); // 0.100 − 6·0.015 = 0.010 is more than 3 N hold, −0.005 is where it stops
}

/// ∫F v dt against the rise of the stored energy ½ z²/σ (Dahl) or ½ σ₀ z² (LuGre), sample by sample.
fn least_surplus<L: FrictionLaw<f64>>(law: &L, stored: impl Fn(&L::State) -> f64) -> f64 {
    let mut state = L::State::default();
    let (mut done, mut least, mut last) = (0.0, f64::INFINITY, 0.0);
    let dt = 1e-6;
    let at = |k: usize| 2e-4 * (f64::sin(40.0 * k as f64 * dt) + 0.7 * f64::sin(171.0 * k as f64 * dt));
    for k in 0..1_000_000 {
        let path = [at(k), at(k + 1)];
        let force = along(law, &mut state, &path, dt)[0];
        done += 0.5 * (last + force) * (path[1] - path[0]);
        last = force;
        least = f64::min(least, done - stored(&state));
    }
    least
}

#[test]
fn bristles_never_give_back_more_than_they_store() {
    let d = Dahl { viscous: 0.0, limit_n: 3.3122, ..dahl() };
    let surplus = least_surplus(&d, |s| 0.5 * s.z * s.z / d.sigma);
    println!("dahl: ∫F dx − stored ≥ {surplus:.1e} J");
    assert!(surplus > -1e-9);
    let l = lugre();
    assert!(l.is_passive());
    let surplus = least_surplus(&l, |s| 0.5 * l.sigma_0 * s.z * s.z);
    println!("lugre: ∫F dx − stored ≥ {surplus:.1e} J");
    assert!(surplus > -1e-9);
    let active = LuGre { sigma_1: 500.0, sigma_2: 0.1, coulomb: 1.0, ..lugre() };
    assert!(!active.is_passive());
}

#[test]
fn a_thrown_block_only_slows_down() {
    for law in [Law::Karnopp(rubber()), Law::Coulomb(coulomb())] {
        let mut block = Block::new(law, MASS, 1e-3);
        block.v = 1.0;
        let mut before = block.v;
        for _ in 0..2000 {
            block.push(0.0);
            assert!(block.v.abs() <= before);
            before = block.v.abs();
        }
        println!("{:8} thrown at 1 m/s: {:.4} m, then at rest, v = {:.1e}", law.id(), block.x, block.v);
        assert!(block.v.abs() < 1e-15);
    }
}
