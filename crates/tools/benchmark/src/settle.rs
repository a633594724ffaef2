//! The state in which a free run begins, from the first samples of a test.

use crate::data::Record;
use crate::free_run::{State, free_run};
use crate::plant::Plant;
use friction::Scalar;
use num_dual::Dual64;
use std::ops::Range;

/// Steps of Gauss and Newton: the run is nearly linear in its beginning.
const STEPS: usize = 6;

/// State at the beginning of `window` for which the run fits the first `settling` samples best.
///
/// The state depends on the parameters. In a scalar with derivatives the last step carries them, by the derivative of
/// the solution of the least squares.
pub fn settled<S: Scalar>(
    plant: &Plant<S>,
    value: &Plant<f64>,
    record: &Record,
    window: &Range<usize>,
    settling: usize,
) -> State<S> {
    let samples = settling.min(window.len()).max(2);
    let measured = &record.position[window.start..window.start + samples];
    let seconds = (samples - 1) as f64 * record.drive.dt();
    let mut state =
        State { position: measured[0], velocity: (measured[samples - 1] - measured[0]) / seconds };
    let mut weights = None;
    for _ in 0..STEPS {
        let Some(gain) = sensitivities(value, record, window.start, samples, state).and_then(|j| inverse(&j))
        else {
            break;
        };
        let run = free_run(value, &record.drive, window.start, samples, state, record.bound);
        let [dx, dv] = applied(&gain, run.iter().zip(measured).map(|(x, y)| x - y));
        weights = Some(gain);
        if !(dx.is_finite() && dv.is_finite()) {
            break;
        }
        state = State { position: state.position - dx, velocity: state.velocity - dv };
    }
    let lifted = State { position: S::lit(state.position), velocity: S::lit(state.velocity) };
    let Some(gain) = weights.filter(|_| state.position.is_finite() && state.velocity.is_finite()) else {
        return lifted;
    };
    let run = free_run(plant, &record.drive, window.start, samples, lifted, record.bound);
    let errors = run.iter().zip(measured).map(|(x, y)| *x - S::lit(*y));
    let [dx, dv] = applied(&gain, errors);
    State { position: lifted.position - dx, velocity: lifted.velocity - dv }
}

/// Derivatives of the run by position and velocity at its beginning.
fn sensitivities(
    plant: &Plant<f64>,
    record: &Record,
    first: usize,
    samples: usize,
    state: State<f64>,
) -> Option<[Vec<f64>; 2]> {
    let plant = plant.lifted::<Dual64>();
    let run = |x: Dual64, v: Dual64| -> Vec<f64> {
        let start = State { position: x, velocity: v };
        let run = free_run(&plant, &record.drive, first, samples, start, record.bound);
        run.iter().map(|x| x.eps).collect()
    };
    let (x, v) = (Dual64::from(state.position), Dual64::from(state.velocity));
    let both = [run(x.derivative(), v), run(x, v.derivative())];
    both.iter().flatten().all(|d| d.is_finite()).then_some(both)
}

/// Weights (JᵀJ)⁻¹Jᵀ; None where the samples do not determine both.
fn inverse([a, b]: &[Vec<f64>; 2]) -> Option<[Vec<f64>; 2]> {
    let dot = |x: &[f64], y: &[f64]| signals::dot(x, y);
    let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
    let determinant = aa * bb - ab * ab;
    if !(determinant > 1e-12 * aa * bb) {
        return None;
    }
    let row = |p: f64, q: f64| a.iter().zip(b).map(|(a, b)| (p * a + q * b) / determinant).collect();
    Some([row(bb, -ab), row(-ab, aa)])
}

fn applied<S: Scalar>(gain: &[Vec<f64>; 2], errors: impl Iterator<Item = S>) -> [S; 2] {
    let (mut x, mut v) = (S::zero(), S::zero());
    for ((gx, gv), e) in gain[0].iter().zip(&gain[1]).zip(errors) {
        x += S::lit(*gx) * e;
        v += S::lit(*gv) * e;
    }
    [x, v]
}
