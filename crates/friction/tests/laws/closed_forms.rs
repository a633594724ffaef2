//! The laws of chapters 2 and 4.2 against what their equations say in closed form.

use crate::common::{along, dahl, triangle};
use friction::{
    Adhesion, Armstrong, Bristle, Classic, Dahl, ElastoPlastic, FrictionLaw, HaywardArmstrong, LuGre,
    MajdSimaan, MaxwellSlip, Motion, Viscous,
};

const DT: f64 = 1e-3;

/// The force at a steady velocity.
fn steady<L: FrictionLaw<f64>>(law: &L, v: f64, seconds: f64, dt: f64) -> f64 {
    let mut state = L::State::default();
    let motion = Motion { dt, velocity: v, displacement: v * dt, ..Motion::default() };
    let steps = (seconds / dt).round() as usize;
    (0..steps).map(|_| law.step(&mut state, &motion)).last().unwrap_or(0.0)
}

fn at<L: FrictionLaw<f64>>(law: &L, v: f64) -> f64 {
    steady(law, v, DT, DT)
}

#[test]
fn viscous_is_eq_2_3() {
    let law = Viscous { damping_p: 35.0, damping_n: 20.0 };
    assert_eq!((at(&law, 0.1), at(&law, -0.1), at(&law, 0.0)), (3.5, -2.0, 0.0));
}

#[test]
fn classic_passes_through_its_corners() {
    let law = Classic { stiction: 3.5, dynamic: 3.0, viscous: 2.0, knee: 0.005, fallen: 0.02 };
    for (v, f) in [(0.0, 0.0), (0.0025, 1.75), (0.005, 3.5), (0.0125, 3.25), (0.02, 3.0), (0.12, 3.2)] {
        assert!((at(&law, v) - f).abs() < 1e-12 && (at(&law, -v) + f).abs() < 1e-12, "{v}");
    }
}

#[test]
fn majd_simaan_has_given_stiction_and_slopes() {
    let law =
        MajdSimaan { viscous: 8.0, coulomb: 3.0, stribeck: 0.0, critical_velocity: 0.02, steepness: 40.0 }
            .with_stiction(4.0);
    let peak =
        (1..200_000).map(|k| 1e-6 * f64::from(k)).map(|v| at(&law, v) - 8.0 * v).fold(0.0_f64, f64::max);
    let slope = (at(&law, 1e-9) - at(&law, -1e-9)) / 2e-9;
    println!("σ = {:.5} N, largest {peak:.6} N (4), slope at rest {slope:.1} N·s/m", law.stribeck);
    assert!((peak - 4.0).abs() < 1e-6);
    assert!((slope / law.slope_at_rest() - 1.0).abs() < 1e-5);
    assert!((at(&law, 1.0) - 11.0).abs() < 1e-9, "f_c + f_v v far out");
    assert_eq!(at(&law, 0.0), 0.0);
}

fn hayward(adhesion: Adhesion) -> HaywardArmstrong<f64> {
    HaywardArmstrong { stiffness: 1e4, dynamic: 3.0, stiction: 3.5, viscous: 0.0, adhesion }
}

#[test]
fn stick_slide_is_a_clipped_spring() {
    let path = triangle(1e-3, 1000);
    let forces = along(&hayward(Adhesion::StickSlide), &mut Default::default(), &path, DT);
    let mut spring = 0.0_f64;
    for (pair, force) in path.windows(2).zip(&forces) {
        spring = (spring + 1e4 * (pair[1] - pair[0])).clamp(-3.0, 3.0);
        assert!((spring - force).abs() < 1e-9, "{spring} {force}");
    }
}

/// Rises of the saw in a path of forces.
fn slips(forces: &[f64]) -> usize {
    forces.windows(2).filter(|w| w[1] < w[0] - 0.1).count()
}

#[test]
fn stick_slip_slide_slips_once_per_distance_at_any_step() {
    let law = hayward(Adhesion::StickSlipSlide);
    let gap: f64 = 0.5 / 1e4;
    for steps in [20_001, 200_003] {
        let path: Vec<f64> = (0..=steps).map(|k| 0.01 * k as f64 / steps as f64).collect();
        let forces = along(&law, &mut Default::default(), &path, DT);
        let expected = (0.01 - 3.0e-4) / gap;
        println!("{} slips in 10 mm with {steps} steps; in continuous motion {expected:.0}", slips(&forces));
        assert!((slips(&forces) as f64 / expected - 1.0).abs() < 0.02);
        let most = forces.iter().copied().fold(0.0_f64, f64::max);
        assert!((3.49..=3.5).contains(&most));
    }
}

#[test]
fn stick_creep_slip_slide_follows_its_equation() {
    let law = hayward(Adhesion::StickCreepSlipSlide);
    // dz/dx = 1 − (z/z_max) z⁸/(z_stick⁸ + z⁸): zero where z⁹ = z_max (z_stick⁸ + z⁸)
    let path: Vec<f64> = (0..=400_000).map(|k| 1e-8 * f64::from(k)).collect();
    let forces = along(&law, &mut Default::default(), &path, DT);
    let z = forces.last().expect("forces") / 1e4;
    let rest = z.powi(9) / (3e-4 * (3.5e-4_f64.powi(8) + z.powi(8))) - 1.0;
    println!("creeps at {:.4} N, the equation is met to {rest:.1e}", z * 1e4);
    assert!(rest.abs() < 1e-3);
}

#[test]
fn a_vibrating_load_moves_only_drifting_laws() {
    // ±10 µm about a point at half the level: the force that is left after 1 000 cycles
    let path: Vec<f64> = (0..64_000)
        .map(|k| {
            1.5e-4_f64.min(1e-6 * f64::from(k)) + 1e-5 * (f64::from(k) * core::f64::consts::TAU / 64.0).sin()
        })
        .collect();
    let left = |forces: &[f64]| {
        let mean = |f: &[f64]| f.iter().sum::<f64>() / f.len() as f64;
        mean(&forces[forces.len() - 64..]) / mean(&forces[320..384])
    };
    let symmetric = Dahl { limit_p: 3.0, limit_n: 3.0, sigma: 1e4, viscous: 0.0, ..dahl() };
    let elastic = ElastoPlastic {
        sigma_0: 1e4,
        sigma_1: 0.0,
        sigma_2: 0.0,
        coulomb: 3.0,
        stiction: 3.0,
        stribeck_velocity: 0.01,
        elastic: 0.7,
    };
    let dahl = left(&along(&symmetric, &mut Default::default(), &path, DT));
    let held = left(&along(&elastic, &mut Default::default(), &path, DT));
    let hayward = left(&along(&hayward(Adhesion::StickSlide), &mut Default::default(), &path, DT));
    println!("force kept: Dahl {dahl:.3}, elasto-plastic {held:.6}, Hayward-Armstrong {hayward:.6}");
    assert!(dahl < 0.5);
    assert!((held - 1.0).abs() < 1e-9 && (hayward - 1.0).abs() < 1e-9);
}

#[test]
fn bristles_break_away_at_three_halves() {
    let law: Bristle<f64> = Bristle { stiffness: 3e4, level: 3.0, viscous: 0.0 };
    let snapping = law.snapping_point();
    assert!((snapping - 1.5e-4).abs() < 1e-18);
    // 0.02 Δ a step; 20 000 Δ
    let path: Vec<f64> = (0..=1_000_000).map(|k| 0.02 * snapping * f64::from(k)).collect();
    let forces = along(&law, &mut Default::default(), &path, DT);
    let first = forces[..60].iter().copied().fold(0.0_f64, f64::max);
    let sliding = &forces[1000..];
    let mean = sliding.iter().sum::<f64>() / sliding.len() as f64;
    let variance = sliding.iter().map(|f| (f - mean) * (f - mean)).sum::<f64>() / sliding.len() as f64;
    // of one bond σΔ/N·√(1/18), fifty independent ones
    let expected = 3.0 * 1.5 / (18.0 * 50.0_f64).sqrt();
    println!(
        "break-away {first:.3} N (4.5), mean {mean:.4} N (3), std {:.4} N ({expected:.4})",
        variance.sqrt()
    );
    assert!((first - 4.5).abs() < 0.1);
    assert!((mean / 3.0 - 1.0).abs() < 0.01);
    assert!((variance.sqrt() / expected - 1.0).abs() < 0.05);
    // steps of many snapping points keep the level
    let path: Vec<f64> = (0..=20_000).map(|k| 40.0 * snapping * f64::from(k)).collect();
    let forces = along(&law, &mut Default::default(), &path, DT);
    let mean = forces.iter().sum::<f64>() / forces.len() as f64;
    println!("mean with steps of 40 Δ: {mean:.4} N");
    assert!((mean / 3.0 - 1.0).abs() < 0.01);
}

#[test]
fn elasto_plastic_level_is_independent_of_step() {
    let law = ElastoPlastic {
        sigma_0: 5e4,
        sigma_1: 0.0,
        sigma_2: 2.0,
        coulomb: 3.0,
        stiction: 4.0,
        stribeck_velocity: 0.01,
        elastic: 0.7,
    };
    for v in [1e-4, 1e-3, 1e-2, 1e-1] {
        let expected = law.level(v) + 2.0 * v;
        assert!((steady(&law, v, 5e-3 / v, DT) - expected).abs() < 1e-9 * expected, "{v}");
    }
    // the path to it, in coarse and in fine steps
    let run = |steps: usize| {
        let path: Vec<f64> = (0..=steps).map(|k| 1.2e-4 * k as f64 / steps as f64).collect();
        *along(&law, &mut Default::default(), &path, 1.0 / steps as f64).last().expect("a force")
    };
    let (coarse, fine) = (run(20), run(20_000));
    println!("at 0.12 mm: {coarse:.5} N in 20 steps, {fine:.5} N in 20 000");
    assert!((coarse / fine - 1.0).abs() < 2e-3);
    // elastic up to 0.7 F_c
    let path = triangle(0.69 * 3.0 / 5e4, 10);
    let forces = along(&law, &mut Default::default(), &path, 1e6);
    assert!(forces.last().expect("a force").abs() < 1e-9, "all of it comes back");
}

#[test]
fn maxwell_slip_obeys_masing_rules() {
    let law = MaxwellSlip::new(3.0, 1e-4);
    assert!((law.share.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    let mut state = Default::default();
    let ramp = |from: f64, to: f64| (0..=2000).map(move |k| from + (to - from) * f64::from(k) / 2000.0);
    let up: Vec<f64> = ramp(0.0, 1.5e-4).collect();
    let virgin = along(&law, &mut state, &up, DT);
    let shape = |x: f64| 1.0 - (-x / 1e-4).exp();
    for i in 0..3 {
        let x = 0.5e-4 * (f64::from(i) + 0.5);
        let k = (x / 1.5e-4 * 2000.0).round() as usize;
        let expected = 3.0 * shape(x) / shape(2.75e-4);
        assert!((virgin[k - 1] - expected).abs() < 0.01, "{} {expected}", virgin[k - 1]);
    }
    let turned = virgin[1999];
    // Masing: the way back is the virgin curve at twice the scale
    let mut masing = state;
    let back = along(&law, &mut masing, &ramp(1.5e-4, 0.0).collect::<Vec<_>>(), DT);
    for k in (100..1000).step_by(100) {
        let expected = turned - 2.0 * virgin[k - 1];
        assert!((back[2 * k - 1] - expected).abs() < 1e-9, "{} {expected}", back[2 * k - 1]);
    }
    // non-local memory: an inner loop closes where it left the outer
    let before = along(&law, &mut state, &ramp(1.5e-4, 0.9e-4).collect::<Vec<_>>(), DT)[1999];
    let turn = state;
    along(&law, &mut state, &ramp(0.9e-4, 1.2e-4).collect::<Vec<_>>(), DT);
    let after = along(&law, &mut state, &ramp(1.2e-4, 0.9e-4).collect::<Vec<_>>(), DT)[1999];
    println!("inner loop leaves at {before:.6} N, comes back at {after:.6} N");
    assert!((before - after).abs() < 1e-9);
    let apart = state.force.iter().zip(&turn.force).map(|(a, b)| (a - b).abs()).fold(0.0_f64, f64::max);
    assert!(apart < 1e-9, "every element is where it was");
}

#[test]
fn armstrong_rises_falls_and_remembers() {
    let law = Armstrong {
        coulomb: 3.0,
        viscous: 4.0,
        stribeck: 1.0,
        stiffness: 5e4,
        stribeck_velocity: 0.01,
        memory: 0.0,
        dwell: 0.5,
    };
    // break-away after a rest of t₂: F_C + F_S∞ t₂/(t₂ + γ), seen with a fine slow pull
    for rest in [0.1, 0.5, 2.0] {
        let mut state = Default::default();
        let dt = 1e-4;
        let still = Motion { dt, ..Motion::default() };
        for _ in 0..(rest / dt) as usize {
            law.step(&mut state, &still);
        }
        let pull = Motion { dt, velocity: 5e-3, displacement: 5e-7, ..Motion::default() };
        let most = (0..2000).map(|_| law.step(&mut state, &pull)).fold(0.0_f64, f64::max) - 4.0 * 5e-3;
        // the pull itself takes time, up to 8 cN more
        let expected = 3.0 + rest / (rest + 0.5);
        println!("after {rest} s: {most:.3} N, {expected:.3} at the start of the pull");
        assert!((-0.026..0.08).contains(&(most - expected)), "to one step of the spring");
    }
    // Stribeck, from a contact that had rested for long
    let mut state = Default::default();
    law.step(&mut state, &Motion { dt: 1e6, ..Motion::default() });
    let go = |v: f64| Motion { dt: DT, velocity: v, displacement: v * DT, ..Motion::default() };
    for v in [0.1, 0.03, 0.01, 0.1] {
        let force = (0..100).map(|_| law.step(&mut state, &go(v))).last().expect("a force");
        let expected = 3.0 + 4.0 * v + 1.0 / (1.0 + (v / 0.01).powi(2));
        assert!((force - expected).abs() < 1e-5, "{v}: {force} {expected}");
    }
    // memory: after a step in velocity v_L comes with its time constant
    let lagging = Armstrong { memory: 0.05, ..law };
    let mut state = Default::default();
    lagging.step(&mut state, &Motion { dt: 1e6, ..Motion::default() });
    for _ in 0..1000 {
        lagging.step(&mut state, &go(0.03));
    }
    for _ in 0..50 {
        lagging.step(&mut state, &go(0.01));
    }
    let expected = 0.01 + 0.02 * (-1.0_f64).exp();
    assert!((state.lagged - expected).abs() < 1e-9, "{} {expected}", state.lagged);
}

#[test]
fn single_precision_stays_near_double_over_a_minute() {
    let motion = |k: usize| {
        let t = k as f64 * DT;
        (0.05 * (6.0 * t).cos(), 0.05 * ((6.0 * (t + DT)).sin() - (6.0 * t).sin()) / 6.0)
    };
    let double = MaxwellSlip::new(3.0_f64, 1e-4);
    let single = MaxwellSlip::new(3.0_f32, 1e-4);
    let plastic = |s: f64| ElastoPlastic {
        sigma_0: 5e4 * s,
        sigma_1: 0.0,
        sigma_2: 2.0,
        coulomb: 3.0,
        stiction: 4.0,
        stribeck_velocity: 0.01,
        elastic: 0.7,
    };
    let plastic_32 = ElastoPlastic::<f32> {
        sigma_0: 5e4,
        sigma_1: 0.0,
        sigma_2: 2.0,
        coulomb: 3.0,
        stiction: 4.0,
        stribeck_velocity: 0.01,
        elastic: 0.7,
    };
    let (mut a, mut b, mut c, mut d) =
        (Default::default(), Default::default(), Default::default(), Default::default());
    let mut apart = [0.0_f64; 2];
    for k in 0..60_000 {
        let (v, dx) = motion(k);
        let wide = Motion { dt: DT, velocity: v, displacement: dx, ..Motion::default() };
        let narrow =
            Motion { dt: DT as f32, velocity: v as f32, displacement: dx as f32, ..Motion::default() };
        apart[0] = apart[0].max((double.step(&mut a, &wide) - f64::from(single.step(&mut b, &narrow))).abs());
        apart[1] = apart[1]
            .max((plastic(1.0).step(&mut c, &wide) - f64::from(plastic_32.step(&mut d, &narrow))).abs());
    }
    println!("f32 from f64 in 60 s: Maxwell slip {:.1e} N, elasto-plastic {:.1e} N", apart[0], apart[1]);
    assert!(apart.iter().all(|a| *a < 2e-3));
}

/// What a LuGre contact and an elasto-plastic one have in common.
#[test]
fn elasto_plastic_and_lugre_slide_alike() {
    let lugre = LuGre {
        sigma_0: 5e4,
        sigma_1: 0.0,
        sigma_2: 2.0,
        coulomb: 3.0,
        stiction: 4.0,
        stribeck_velocity: 0.01,
    };
    let plastic = ElastoPlastic::of(lugre, 0.7);
    for v in [1e-3, 0.01, 0.1] {
        assert!((steady(&lugre, v, 5e-3 / v, DT) - steady(&plastic, v, 5e-3 / v, DT)).abs() < 1e-9);
    }
}
