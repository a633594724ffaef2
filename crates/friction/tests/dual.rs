//! Exact derivatives, by running the law on dual numbers. (`cargo test -p friction --features dual`)
#![cfg(feature = "dual")]

mod common;
use common::{coulomb, dahl, lugre, rubber};
use friction::effects::{EffectKind, MAX_MEMORY};
use friction::{Coulomb, Dahl, FrictionLaw, Karnopp, LuGre, Motion, Scalar};
use num_dual::{Dual64, DualSVec64};

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

/// Forces of the law that `build` makes of `parameters`, with the gradient of each.
fn by_duals<const N: usize, L: FrictionLaw<DualSVec64<N>>>(
    build: impl Fn([DualSVec64<N>; N]) -> L,
    parameters: [f64; N],
) -> Vec<(f64, [f64; N])> {
    let mut index = 0;
    let law = build(parameters.map(|value| {
        index += 1;
        DualSVec64::<N>::lit(value).derivative(index - 1)
    }));
    let mut state = L::State::default();
    constant(&path())
        .iter()
        .map(|motion| {
            let force = law.step(&mut state, motion);
            let gradient = force.eps.unwrap_generic(num_dual_const::<N>(), nalgebra_one());
            (force.re, core::array::from_fn(|k| gradient[k]))
        })
        .collect()
}
