//! A change at one moment: a force, a level of friction or a viscous coefficient that is another from then on. As a curve
//! over the time it has two knots, as far apart as two rows; a smooth curve would spread the step over seconds.

use crate::findings::locate::row_times;
use crate::free_form::candidate::Candidate;
use crate::free_form::term::FreeTerm;
use crate::library::baseline::{BACKWARD, FORWARD};
use crate::library::design_matrix::DesignMatrix;
use friction::{Coordinate, Factor};
use signals::Basis;

/// Blocks that have to be there before a change, and after it.
const BLOCKS: usize = 2;

/// Smallest share of what changes that has to lie outside of everything else.
const OUTSIDE: f64 = 1e-3;

/// The best moment of each thing that may change, and its rows for other moments: the family of which the best was taken.
#[derive(Default)]
pub struct Changes {
    pub candidates: Vec<Candidate>,
    pub others: Vec<Vec<f64>>,
}

/// What may change, by row: the sum of columns of the baseline, each with its sign.
pub fn kinds(design: &DesignMatrix) -> Vec<(Factor, Vec<f64>)> {
    let sum = |of: [(usize, f64); 2]| {
        let mut out = vec![0.0; design.y.len()];
        for (wanted, sign) in of {
            let column = design.present.iter().position(|p| *p == wanted).map(|i| &design.baseline[i]);
            for (s, x) in out.iter_mut().zip(column.into_iter().flatten()) {
                *s += sign * x;
            }
        }
        out
    };
    let ([_, c_p, b_p], [_, c_n, b_n]) = (FORWARD, BACKWARD);
    // in one direction a force and a level of friction are the same
    let force = (!design.is_one_way()).then(|| (Factor::One, sum([(c_p, 1.0), (c_n, -1.0)])));
    let friction = [
        (Factor::Direction, sum([(c_p, 1.0), (c_n, 1.0)])),
        (Factor::Velocity, sum([(b_p, 1.0), (b_n, 1.0)])),
    ];
    force.into_iter().chain(friction).collect()
}

impl Changes {
    /// Changes that explain `residual`, beside what spans `basis`. None in several recordings: what happened at a moment of
    /// one did not happen at that moment of another.
    pub fn new(design: &DesignMatrix, basis: &Basis, residual: &[f64]) -> Self {
        let mut out = Self::default();
        let Some(inner) = inner(design) else { return out };
        let times = row_times(design);
        for (factor, column) in kinds(design) {
            let Some(row) = best(&column, basis, residual, inner, |_| true) else { continue };
            out.candidates.push(Candidate::change(moment_of(design, &times, row), factor));
            out.others.extend(at_other_moments(&column, inner));
        }
        out
    }
}

/// Edges of the blocks between which something may change; none where there are several recordings, or too few blocks.
pub fn inner(design: &DesignMatrix) -> Option<&[usize]> {
    let one = design.tracks.windows(2).all(|t| t[0].raw.recording == t[1].raw.recording);
    let edges = &design.blocks.edges;
    (one && edges.len() >= 4 * BLOCKS).then(|| &edges[BLOCKS..edges.len() - BLOCKS])
}

/// The moment between a row and the one before, s since the start; `times` are those of the rows.
pub fn moment_of(design: &DesignMatrix, times: &[f64], row: usize) -> f64 {
    let start = design.tracks.first().map_or(0.0, |t| t.raw.start);
    0.5 * (times[row - 1] + times[row]) - start
}

/// The first row of the part of `column` that explains most of `residual`, among those inside `edges` that are `allowed`.
pub fn best(
    column: &[f64],
    basis: &Basis,
    residual: &[f64],
    edges: &[usize],
    allowed: impl Fn(usize) -> bool,
) -> Option<usize> {
    let (first, last) = (*edges.first()?, *edges.last()?);
    let whole: f64 = column.iter().map(|x| x * x).sum();
    let (mut power, mut moment) = (0.0, 0.0);
    let mut along = vec![0.0; basis.columns().len()];
    let mut found: Option<(f64, usize)> = None;
    for row in (first.max(1)..column.len()).rev() {
        let x = column[row];
        power += x * x;
        moment += x * residual[row];
        for (a, q) in along.iter_mut().zip(basis.columns()) {
            *a += x * q[row];
        }
        let left = power - along.iter().map(|a| a * a).sum::<f64>();
        if row <= last && allowed(row) && left > OUTSIDE * whole {
            let gain = moment * moment / left;
            if found.is_none_or(|(most, _)| gain > most) {
                found = Some((gain, row));
            }
        }
    }
    found.map(|(_, row)| row)
}

/// The part of `column` from a row on.
pub fn from(column: &[f64], row: usize) -> Vec<f64> {
    column.iter().enumerate().map(|(r, x)| if r < row { 0.0 } else { *x }).collect()
}

/// The same for every other moment inside: the family of which the best was taken.
pub fn at_other_moments<'a>(column: &'a [f64], inner: &'a [usize]) -> impl Iterator<Item = Vec<f64>> + 'a {
    inner.iter().step_by(2).map(|edge| from(column, *edge))
}

/// What a free form says that is a change.
#[derive(Debug, Clone, Copy)]
pub struct Change {
    /// Moment, s since the start.
    pub at: f64,
    pub before: f64,
    pub after: f64,
    /// Standard deviation of the size.
    pub std: f64,
}

impl Change {
    /// None of another form.
    pub fn of(term: &FreeTerm) -> Option<Self> {
        let form = &term.form;
        match (form.over, form.across, form.knots.places(), form.values(), term.std.as_slice()) {
            (Coordinate::Time, None, [low, high], &[before, after], [std, _]) => {
                let at = 0.5 * (low + high);
                // both values follow from one coefficient, and so do their deviations
                Some(Self { at, before, after, std: (std * (after - before) / before).abs() })
            }
            _ => None,
        }
    }

    pub fn size(&self) -> f64 {
        self.after - self.before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_row_of_a_step_beside_what_else_is_there() {
        let wave: Vec<f64> = (0..900).map(|i| (0.05 * f64::from(i)).sin()).collect();
        let way: Vec<f64> = wave.iter().map(|x| x.signum()).collect();
        let y: Vec<f64> = (0..900)
            .map(|i| 3.0 * way[i] + 0.5 * wave[i] + if i < 512 { 0.0 } else { 0.1 * way[i] })
            .collect();
        let basis = Basis::of(&[&way[..], &wave[..]]);
        assert_eq!(best(&way, &basis, &basis.project_out(&y), &[100, 800], |_| true), Some(512));
        // nothing but the whole is left of it: it cannot have changed
        assert_eq!(best(&[0.0; 900], &basis, &y, &[100, 800], |_| true), None);
    }
}
