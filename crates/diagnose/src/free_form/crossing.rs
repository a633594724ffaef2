//! Whether a free form holds where another coordinate is different. A form has no law behind it, and in a motion that
//! repeats everything depends on everything: a map over velocity and acceleration then stands for the position, and is of
//! no use in the next motion.

use crate::findings::locate::row_motion;
use crate::free_form::candidate::Candidate;
use crate::free_form::term::FreeTerm;
use crate::library::design_matrix::DesignMatrix;
use crate::regression::linear::solve;
use friction::Coordinate;
use signals::{Basis, dot, quantile};

/// Parts of the other coordinate that are each left out in turn: thirds for a map. For a curve each is every third of
/// [`BANDS`] bands, so that the slow ends and the quick middle of a stroke are in all of them.
const PARTS: usize = 3;
const BANDS: usize = 9;
/// Share of what a form explains where it was fitted that it has to explain where it was not.
const HOLDS: f64 = 0.5;
/// Further penalty, as a share of a column's power. A column that the other parts do not excite gets no force.
const PRIOR: f64 = 1e-3;

/// The coordinates, by row, over which a form has to hold.
fn others(design: &DesignMatrix, candidate: &Candidate) -> Vec<Vec<f64>> {
    let (position, velocity) = row_motion(design);
    let has = |c: Coordinate| candidate.reads(c);
    let magnitudes = |of: &[f64]| of.iter().map(|x| x.abs()).collect();
    match (has(Coordinate::Position), has(Coordinate::Velocity)) {
        // the first column of the baseline is the acceleration
        (true, true) => vec![magnitudes(&design.baseline[0])],
        (true, false) => vec![magnitudes(&velocity)],
        (false, true) => vec![position],
        // each moment is there once, and with it the speeds at that moment
        (false, false) if has(Coordinate::Time) => vec![position],
        (false, false) => vec![magnitudes(&velocity), position],
    }
}

/// Whether `term` explains the force in each part of every other coordinate, fitted on the others. `basis` is the span of
/// everything else.
pub fn holds(design: &DesignMatrix, candidate: &Candidate, basis: &Basis, term: &FreeTerm) -> bool {
    let own: Vec<Vec<f64>> = term.columns.iter().map(|c| basis.project_out(c)).collect();
    let prior = |(c, penalty): (&Vec<f64>, &f64)| penalty + PRIOR * dot(c, c);
    let penalties: Vec<f64> = own.iter().zip(&term.penalties).map(prior).collect();
    let y = basis.project_out(&design.y);
    others(design, candidate).iter().all(|other| holds_over(other, design, candidate, &own, &penalties, &y))
}

/// The same over one coordinate, of what is outside the span.
fn holds_over(
    other: &[f64],
    design: &DesignMatrix,
    candidate: &Candidate,
    own: &[Vec<f64>],
    penalties: &[f64],
    y: &[f64],
) -> bool {
    let used: Vec<usize> =
        (0..other.len()).filter(|r| design.share[*r] > 0.5 && other[*r].is_finite()).collect();
    let values: Vec<f64> = used.iter().map(|r| other[*r]).collect();
    let edges: Vec<f64> = (1..BANDS).map(|k| quantile(&values, k as f64 / BANDS as f64)).collect();
    let part_of = |r: &usize| {
        let band = edges.partition_point(|e| *e <= other[*r]);
        if candidate.across.is_some() { band * PARTS / BANDS } else { band % PARTS }
    };
    let fitted = |rows: &[usize]| {
        let of = |column: &[f64]| rows.iter().map(|r| column[*r]).collect::<Vec<f64>>();
        solve(&own.iter().map(|c| of(c)).collect::<Vec<_>>(), penalties, &of(y))
    };
    let error = |rows: &[usize], coefficients: &[f64]| -> f64 {
        let left = |r: &usize| y[*r] - own.iter().zip(coefficients).map(|(c, b)| c[*r] * b).sum::<f64>();
        rows.iter().map(|r| left(r).powi(2)).sum()
    };
    let Some(all) = fitted(&used) else { return false };
    let none = vec![0.0; own.len()];
    let (mut without, mut there, mut elsewhere) = (0.0, 0.0, 0.0);
    for k in 0..PARTS {
        let (part, rest): (Vec<usize>, Vec<usize>) = used.iter().copied().partition(|r| part_of(r) == k);
        let Some(coefficients) = fitted(&rest) else { return false };
        without += error(&part, &none);
        there += error(&part, &all);
        elsewhere += error(&part, &coefficients);
    }
    without - elsewhere >= HOLDS * (without - there)
}
