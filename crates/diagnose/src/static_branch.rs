//! Where the baseline's static branch ends: Karnopp's law balances whatever load there is below a speed Δv, so samples
//! slower than that say nothing about sliding, and a step at Δv is no physics that was left out.
//!
//! A step, not a slope: smooth physics at low speed (a Stribeck curve, frictional lag) changes as much in the bins above
//! an edge as across it.

use crate::signal::quantile;
use crate::track::Track;
use nalgebra::{DMatrix, DVector};

/// Bins of |v|, and the share of the top speed they span.
const BINS: usize = 40;
const SPAN: f64 = 0.4;
/// Bins averaged on either side of an edge.
const SIDE: usize = 2;
/// The step in standard errors; samples follow each other, so more than the textbook's.
const SURE: f64 = 6.0;
/// Scatter below the edge over that above: what merely balances goes from one level of friction to the other, a law of
/// sliding at low speed has a value.
const WANDERS: f64 = 3.0;
/// What may change above the edge, as a share of the step.
const FLAT: f64 = 0.25;

/// Δv and half a bin's width, m/s, where the recording shows the step.
pub fn delta_v(tracks: &[Track]) -> Option<(f64, f64)> {
    let used: Vec<(usize, &Track)> =
        tracks.iter().flat_map(|t| (0..t.len()).filter(|&i| t.mask[i] > 0.0).map(move |i| (i, t))).collect();
    let speeds: Vec<f64> = used.iter().map(|(i, t)| t.v[*i].abs()).collect();
    let top = quantile(&speeds, 0.95);
    if !(top > 0.0) {
        return None;
    }
    let excess = excess(&used, 0.5 * SPAN * top)?;
    let width = SPAN * top / BINS as f64;
    let mut bins = [(0.0, 0.0, 0.0); BINS];
    for (e, v) in excess.iter().zip(&speeds) {
        if let Some(bin) = bins.get_mut((v / width) as usize) {
            *bin = (bin.0 + e, bin.1 + e * e, bin.2 + 1.0);
        }
    }
    // mean, squared standard error and variance over some bins
    let over = |from: usize, to: usize| -> Option<(f64, f64, f64)> {
        let (sum, squares, count) =
            bins.get(from..to)?.iter().fold((0.0, 0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
        let mean = sum / count;
        let variance = (squares / count - mean * mean).max(0.0);
        (count >= 20.0).then_some((mean, variance / count, variance))
    };
    let steps = |edge: &usize| -> Option<bool> {
        let edge = *edge;
        let (below, above) = (over(edge.checked_sub(SIDE)?, edge)?, over(edge, edge + SIDE)?);
        let further = over(edge + SIDE, edge + 3 * SIDE)?;
        let jump = (below.0 - above.0).abs();
        let error = (below.1 + above.1).sqrt();
        let flat = (above.0 - further.0).abs() < FLAT * jump;
        let wanders = below.2 > WANDERS * WANDERS * above.2;
        Some(flat && wanders && jump > SURE * error)
    };
    // the highest: rest itself is a step, too, at the bottom of the band
    let edge = (1..BINS).rfind(|edge| steps(edge) == Some(true))?;
    Some((edge as f64 * width, 0.5 * width))
}

/// Force beyond what sliding explains, against the motion, at every sample used. What sliding explains is fitted to the
/// samples faster than `slow`, generously: inertia, friction of either direction, drag, springs, friction along the
/// stroke.
fn excess(used: &[(usize, &Track)], slow: f64) -> Option<Vec<f64>> {
    let row = |i: usize, t: &Track| -> [f64; COLUMNS] {
        let (x, v, s) = (t.x[i], t.v[i], t.sign[i]);
        [t.a[i], s, 1.0, v, s * v, v * v.abs(), v * v, x, x * x, x * x * x, s * x, s * x * x]
    };
    let mut scale = [1e-300_f64; COLUMNS];
    for (i, t) in used {
        for (m, x) in scale.iter_mut().zip(row(*i, t)) {
            *m = m.max(x.abs());
        }
    }
    let mut gram = DMatrix::<f64>::zeros(COLUMNS, COLUMNS);
    let mut moment = DVector::<f64>::zeros(COLUMNS);
    for (i, t) in used.iter().filter(|(i, t)| t.v[*i].abs() > slow) {
        let r = DVector::from_fn(COLUMNS, |c, _| row(*i, t)[c] / scale[c]);
        gram.ger(1.0, &r, &r, 1.0);
        moment.axpy(t.raw.force[*i], &r, 1.0);
    }
    // nearly dependent columns share what they explain
    let ridge = 1e-9 * gram.trace();
    for c in 0..COLUMNS {
        gram[(c, c)] += ridge;
    }
    let solution = gram.cholesky()?.solve(&moment);
    let explained = |i: usize, t: &Track| -> f64 {
        row(i, t).iter().zip(&scale).zip(solution.iter()).map(|((x, m), c)| c * x / m).sum()
    };
    let out: Vec<f64> = used.iter().map(|(i, t)| t.sign[*i] * (t.raw.force[*i] - explained(*i, t))).collect();
    out.iter().all(|e| e.is_finite()).then_some(out)
}

const COLUMNS: usize = 12;
