//! Exact derivatives, by running the law on dual numbers. (`cargo test -p friction --features dual`)
#![cfg(feature = "dual")]

use crate::common::{coulomb, dahl, lugre, rubber};
use friction::effects::{EffectKind, MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Scale};
use friction::{Coulomb, Dahl, Dimension, FrictionLaw, Karnopp, LuGre, Motion, Scalar};
use num_dual::Dual64;

/// A few reversals, long and short.
fn path() -> Vec<f64> {
    (0..400).map(|k| 3e-4 * f64::sin(0.05 * k as f64) + 1e-4 * f64::sin(0.31 * k as f64)).collect()
}

fn constant<S: Scalar>(path: &[f64]) -> Vec<Motion<S>> {
    let motion = |(k, pair): (usize, &[f64])| Motion {
        dt: S::lit(1e-3),
        position: S::lit(pair[1]),
        displacement: S::lit(pair[1] - pair[0]),
        velocity: S::lit((pair[1] - pair[0]) / 1e-3),
        applied: S::lit(3.0 * f64::sin(0.2 * k as f64)),
        mass: S::zero(),
        normal: Some(S::lit(4.1)),
    };
    path.windows(2).enumerate().map(motion).collect()
}

/// Forces along the path of the law that `build` makes of `parameters`.
fn forces<S: Scalar, L: FrictionLaw<S>>(law: &L) -> Vec<S> {
    let mut state = L::State::default();
    constant(&path()).iter().map(|motion| law.step(&mut state, motion)).collect()
}

/// The gradient by running the law on dual numbers, against central differences of the law on plain ones, and the
/// value against the plain law, bit for bit.
fn check<const N: usize, D: FrictionLaw<Dual64>, L: FrictionLaw<f64>>(
    name: &str,
    parameters: [f64; N],
    dual: impl Fn([Dual64; N]) -> D,
    plain: impl Fn([f64; N]) -> L,
) {
    let base = forces(&plain(parameters));
    for k in 0..N {
        let seeded = forces(&dual(core::array::from_fn(|j| {
            Dual64::new(parameters[j], if j == k { 1.0 } else { 0.0 })
        })));
        let h = 1e-6 * parameters[k].abs().max(1e-6);
        let shifted = |h: f64| {
            let mut moved = parameters;
            moved[k] += h;
            forces(&plain(moved))
        };
        let (up, down) = (shifted(h), shifted(-h));
        let (mut worst, mut most) = (0.0_f64, 0.0_f64);
        for (i, force) in seeded.iter().enumerate() {
            // the exponent must not take its shortcut at 1 when a derivative is asked for: equal to rounding only
            assert!((force.re - base[i]).abs() <= 1e-12 * (1.0 + base[i].abs()), "{name}: value at {i}");
            let difference = (up[i] - down[i]) / (2.0 * h);
            worst = worst.max((force.eps - difference).abs());
            most = most.max(difference.abs());
        }
        println!("{name:8} parameter {k}: |dF/dp| up to {most:.3e}, differs from differences by {worst:.1e}");
        assert!(worst <= 1e-5 * most.max(1e-9), "{name} parameter {k}");
        assert!(most > 0.0, "{name} parameter {k} has no effect on this path");
    }
}

#[test]
fn derivatives_of_every_law_are_those_of_differences() {
    let k = rubber();
    // F_a of the path is beyond D_p here, so that every parameter is met
    check(
        "karnopp",
        [k.c_p, k.c_n, k.b_p, k.b_n, 2.0, 2.0],
        |[c_p, c_n, b_p, b_n, d_p, d_n]| Karnopp { c_p, c_n, b_p, b_n, d_p, d_n, delta_v: Dual64::lit(0.02) },
        |[c_p, c_n, b_p, b_n, d_p, d_n]| Karnopp { c_p, c_n, b_p, b_n, d_p, d_n, delta_v: 0.02 },
    );
    let c = coulomb();
    check(
        "coulomb",
        [c.level_p, c.level_n, c.viscous_p, c.viscous_n],
        |[level_p, level_n, viscous_p, viscous_n]| Coulomb {
            level_p,
            level_n,
            static_p: level_p,
            static_n: level_n,
            viscous_p,
            viscous_n,
        },
        |[level_p, level_n, viscous_p, viscous_n]| Coulomb {
            level_p,
            level_n,
            static_p: level_p,
            static_n: level_n,
            viscous_p,
            viscous_n,
        },
    );
    let d = dahl();
    for exponent in [1.0, 1.6] {
        check(
            "dahl",
            [d.limit_p, d.limit_n, d.sigma, exponent, d.viscous],
            |[limit_p, limit_n, sigma, exponent, viscous]| Dahl {
                limit_p,
                limit_n,
                sigma,
                exponent,
                viscous,
            },
            |[limit_p, limit_n, sigma, exponent, viscous]| Dahl {
                limit_p,
                limit_n,
                sigma,
                exponent,
                viscous,
            },
        );
    }
    let l = lugre();
    check(
        "lugre",
        [l.sigma_0, l.sigma_1, l.sigma_2, l.coulomb, l.stiction, l.stribeck_velocity],
        |[sigma_0, sigma_1, sigma_2, coulomb, stiction, stribeck_velocity]| LuGre {
            sigma_0,
            sigma_1,
            sigma_2,
            coulomb,
            stiction,
            stribeck_velocity,
        },
        |[sigma_0, sigma_1, sigma_2, coulomb, stiction, stribeck_velocity]| LuGre {
            sigma_0,
            sigma_1,
            sigma_2,
            coulomb,
            stiction,
            stribeck_velocity,
        },
    );
}

#[test]
fn derivative_of_every_effect_by_its_shape() {
    for &kind in EffectKind::ALL {
        let mut base: [f64; MAX_SHAPE] = [0.0; MAX_SHAPE];
        for (value, p) in base.iter_mut().zip(kind.shape()) {
            // scales of the path: 0.4 mm and 16 mm/s
            *value = match (p.scale, p.dimension) {
                (Scale::Place { from, .. }, _) if from > 50 => 2e-4,
                (Scale::Place { .. }, _) => -2.1e-4,
                (_, Dimension::LENGTH) => 1e-4,
                (_, Dimension::VELOCITY) => 0.006,
                (_, Dimension::TIME) => 0.02,
                _ => 1.3,
            }
            .clamp(p.min, p.max);
        }
        for k in 0..kind.shape().len() {
            let run = |at: f64| {
                let mut shape = base;
                shape[k] = at;
                let mut memory = [0.0; MAX_MEMORY];
                constant::<f64>(&path()).iter().map(|m| kind.unit(&shape, &mut memory, m)).collect::<Vec<_>>()
            };
            let h = 1e-6 * base[k].abs();
            let (up, down, value) = (run(base[k] + h), run(base[k] - h), run(base[k]));
            let shape = core::array::from_fn(|j| Dual64::new(base[j], if j == k { 1.0 } else { 0.0 }));
            let mut memory = [Dual64::lit(0.0); MAX_MEMORY];
            let (mut worst, mut most, mut kinks, mut n) = (0.0_f64, 0.0_f64, 0, 0);
            for (i, motion) in constant::<Dual64>(&path()).iter().enumerate() {
                let unit = kind.unit(&shape, &mut memory, motion);
                for g in 0..MAX_GAINS.min(kind.gains().len()) {
                    assert!((unit[g].re - value[i][g]).abs() <= 1e-12 * (1.0 + value[i][g].abs()));
                    let difference = (up[i][g] - down[i][g]) / (2.0 * h);
                    n += 1;
                    most = most.max(unit[g].eps.abs());
                    // a step of the parameter that crosses a sign change of the lagged velocity is no difference
                    if difference.abs() * h > 1e-2 {
                        kinks += 1;
                        continue;
                    }
                    worst = worst.max((unit[g].eps - difference).abs());
                }
            }
            println!(
                "{:28} {:16} |dF/dp| up to {most:.2e}, differs by {worst:.1e}, {kinks} kinks of {n}",
                kind.id(),
                kind.shape()[k].name
            );
            assert!(worst <= 1e-4 * most.max(1e-6), "{}", kind.id());
            assert!(kinks * 50 <= n);
        }
    }
}

#[test]
fn infinite_derivatives_become_zero() {
    for x in [
        Dual64::new(0.0, 1.0).sqrt(),
        Dual64::new(0.0, 1.0).powf(Dual64::lit(0.5)),
        Dual64::new(0.0, 0.0).ln(),
    ] {
        assert!(!x.eps.is_nan(), "{x:?}");
    }
}

#[test]
fn nearest_force_on_an_ellipse_has_exact_derivatives() {
    use friction::planar::{Grain, Vector};
    let at = |x: f64, across: f64| Grain::at(0.4, across).nearest(Vector { x, y: 2.0 }, 1.5);
    let (x, across, h) = (3.0, 1.7, 1e-6);
    let seeded = |dx: f64, da: f64| {
        let grain = Grain::at(Dual64::lit(0.4), Dual64::new(across, da));
        grain.nearest(Vector { x: Dual64::new(x, dx), y: Dual64::lit(2.0) }, Dual64::lit(1.5))
    };
    let by_force = (at(x + h, across) - at(x - h, across)) * (0.5 / h);
    let by_ratio = (at(x, across + h) - at(x, across - h)) * (0.5 / h);
    for (dual, difference) in [(seeded(1.0, 0.0), by_force), (seeded(0.0, 1.0), by_ratio)] {
        println!("{} and {}, differences {difference:?}", dual.x.eps, dual.y.eps);
        assert!((dual.x.eps - difference.x).abs() < 1e-8 && (dual.y.eps - difference.y).abs() < 1e-8);
    }
    // a disc whose ratio is asked for is an ellipse
    let disc = Grain { across: Dual64::new(1.0, 1.0), ..Grain::at(Dual64::lit(0.4), Dual64::lit(1.0)) };
    let force = disc.nearest(Vector { x: Dual64::lit(3.0), y: Dual64::lit(2.0) }, Dual64::lit(1.5));
    let difference = (at(3.0, 1.0 + h) - at(3.0, 1.0 - h)) * (0.5 / h);
    assert!((force.x.eps - difference.x).abs() < 1e-8 && (force.y.eps - difference.y).abs() < 1e-8);
}
