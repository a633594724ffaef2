//! Time of one step of each law and effect, f32 as on the device and f64 as in the rig.
//!
//! `cargo bench -p friction` prints the median of every one; an item is one step along a sine with a ripple that
//! reverses within it, so that each branch is taken. Cycles on the target are measured on the ELF.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use friction::effects::{Effect, EffectKind, EffectState};
use friction::{Coulomb, Dahl, FrictionLaw, Karnopp, Law, LawState, LuGre, Motion, Scalar};

const STEPS: usize = 4_000;

fn path<S: Scalar>() -> Vec<Motion<S>> {
    let at = |k: usize| {
        let t = S::lit(k as f64 * 1e-3);
        S::lit(0.01) * (S::lit(12.566) * t).sin() + S::lit(2e-4) * (S::lit(301.0) * t).sin()
    };
    (0..STEPS)
        .map(|k| {
            let displacement = at(k + 1) - at(k);
            Motion {
                dt: S::lit(1e-3),
                position: at(k + 1),
                displacement,
                velocity: displacement / S::lit(1e-3),
                applied: S::lit(4.0) * (S::lit(0.017 * k as f64)).sin(),
                mass: S::lit(0.4),
                normal: Some(S::lit(4.1)),
            }
        })
        .collect()
}

/// Aluminium on rubber, by the law of this id.
fn law<S: Scalar>(id: &str) -> Law<S> {
    let n = |x: f64| S::lit(x);
    match id {
        "karnopp" => Law::Karnopp(Karnopp {
            c_p: n(3.4901),
            c_n: n(2.5611),
            b_p: n(8.7338),
            b_n: n(7.9521),
            d_p: n(3.8513),
            d_n: n(2.9099),
            delta_v: n(0.02),
        }),
        "coulomb" => Law::Coulomb(Coulomb {
            level_p: n(3.4901),
            level_n: n(2.5611),
            static_p: n(3.8513),
            static_n: n(2.9099),
            viscous_p: n(8.7338),
            viscous_n: n(7.9521),
        }),
        "lugre" => Law::LuGre(LuGre {
            sigma_0: n(5e4),
            sigma_1: n(60.0),
            sigma_2: n(9.0),
            coulomb: n(3.0),
            stiction: n(3.4),
            stribeck_velocity: n(0.01),
        }),
        _ => Law::Dahl(Dahl {
            limit_p: n(3.3122),
            limit_n: n(2.4238),
            sigma: n(5e4),
            exponent: n(if id == "dahl" { 1.0 } else { 1.5 }),
            viscous: n(9.9812),
        }),
    }
}

/// The laws, and Dahl with a shape that needs a power and a logarithm.
const LAWS: [&str; 5] = ["karnopp", "coulomb", "dahl", "dahl_i_1.5", "lugre"];

#[divan::bench(types = [f32, f64], args = LAWS)]
fn laws<S: Scalar>(bencher: Bencher, id: &str) {
    let (law, path) = (law::<S>(id), path::<S>());
    let mut state = LawState::default();
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        path.iter().fold(S::zero(), |sum, motion| sum + law.step(&mut state, black_box(motion)))
    });
}

fn effect_ids() -> impl Iterator<Item = &'static str> {
    EffectKind::ALL.iter().map(|kind| kind.id())
}

#[divan::bench(args = effect_ids())]
fn effects(bencher: Bencher, id: &str) {
    let kind = EffectKind::from_id(id).expect("of the catalogue");
    let mut effect = Effect { kind, gains: [1.0_f32; 4], shape: [0.01, 0.01] };
    if kind == EffectKind::HardStop {
        effect.shape = [0.005, -0.005];
    }
    let (path, mut state) = (path::<f32>(), EffectState::default());
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        path.iter().fold(0.0, |sum, motion| sum + effect.step(&mut state, black_box(motion)))
    });
}

/// Nanoseconds a step, the best of twenty runs: a shared machine only ever makes it slower.
fn nanoseconds<S: Scalar>(id: &str) -> f64 {
    let (law, path) = (law::<S>(id), path::<S>());
    let mut state = LawState::default();
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let began = std::time::Instant::now();
        for motion in &path {
            black_box(law.step(&mut state, black_box(motion)));
        }
        best = best.min(began.elapsed().as_secs_f64() * 1e9 / STEPS as f64);
    }
    best
}

fn main() {
    divan::main();
    if std::env::args().any(|a| a == "--test" || a == "--list") {
        return;
    }
    for id in LAWS {
        let (narrow, wide) = (nanoseconds::<f32>(id), nanoseconds::<f64>(id));
        println!("{id:10}: {narrow:6.1} ns a step in f32, {wide:6.1} ns in f64");
    }
}
