//! Deviations of everything that was fitted, gains and shapes of all terms and the baseline together: the derivative
//! of every shape is a column of one more fit, so that each interval knows what the others may do.

use crate::regression::linear::FOLDS;
use crate::regression::linear::{Fit, fit};
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::judgement::Search;
use signals::{Basis, dot};

/// The joint fit of a hypothesis, linear in its shapes around where they are.
#[derive(Debug, Clone)]
pub struct Joint {
    std_errors: Vec<f64>,
    shapes: Vec<Vec<Shape>>,
    /// Columns of gains that physics sets, with their deviations where the shape is held instead.
    set: Vec<(usize, f64)>,
}

/// What the recording says about a shape parameter.
#[derive(Debug, Clone, Copy)]
enum Shape {
    /// Nothing depends on it: it belongs to a gain that is not in use.
    Unused,
    /// It acts like other parameters do, or stands at the end of what was tried: no interval.
    Unidentified,
    /// The column of its derivative.
    Column(usize),
}

impl Joint {
    /// Deviations of `found`.
    pub fn of(search: &Search, found: &Hypothesis) -> Self {
        let design = search.design;
        let mut columns: Vec<Vec<f64>> =
            Hypothesis::columns(design, &found.atoms).iter().map(|c| c.to_vec()).collect();
        // The whole force moves in time, and none of it stays: for its time, the share is one.
        let mut set = Vec::new();
        for (i, atom) in found.atoms.iter().enumerate() {
            let gain = found.offset(design, i);
            if atom.term.kind.moves_in_time()
                && let Some(slope) = slope(search, found, i, 0)
            {
                columns[gain] = slope;
                set.push((gain, found.fit.std_errors()[gain]));
            }
        }
        let mut basis = Basis::of(&columns);
        let mut shapes = Vec::new();
        for (i, atom) in found.atoms.iter().enumerate() {
            let gain = found.offset(design, i);
            let placed = (0..atom.term.kind.shape().len()).map(|axis| {
                let held = set.iter().any(|s| s.0 == gain);
                if at_end(search, atom, axis) {
                    return Shape::Unidentified;
                }
                if held {
                    return Shape::Column(gain);
                }
                let Some(slope) = slope(search, found, i, axis) else { return Shape::Unused };
                // what is within rounding of the other columns is not told apart from them
                let fresh = basis.project_out(&slope);
                if dot(&fresh, &fresh) <= 1e-8 * dot(&slope, &slope) || !basis.push(&slope) {
                    return Shape::Unidentified;
                }
                columns.push(slope);
                Shape::Column(columns.len() - 1)
            });
            shapes.push(placed.collect());
        }
        let joint: Option<Fit> = fit(&columns, &design.y, &design.blocks, FOLDS);
        Self { std_errors: joint.as_ref().unwrap_or(&found.fit).std_errors().to_vec(), shapes, set }
    }

    /// Deviation of column `i` of the hypothesis: baseline first, then each term's gains.
    pub fn gain(&self, column: usize) -> f64 {
        match self.set.iter().find(|s| s.0 == column) {
            Some((_, deviation)) => *deviation,
            None => self.of_column(column),
        }
    }

    fn of_column(&self, column: usize) -> f64 {
        self.std_errors.get(column).copied().unwrap_or(f64::NAN)
    }

    /// Deviation of a shape parameter, not a number where it is not identifiable; none where nothing depends on it.
    pub fn shape(&self, atom: usize, axis: usize) -> Option<f64> {
        match self.shapes.get(atom)?.get(axis)? {
            Shape::Unused => None,
            Shape::Unidentified => Some(f64::NAN),
            Shape::Column(column) => Some(self.of_column(*column)),
        }
    }
}

/// Whether a shape parameter stands at an end of the range that was tried: it may lie beyond.
pub fn at_end(search: &Search, atom: &Atom, axis: usize) -> bool {
    let (low, high, log) = search.scales.range(&atom.term.kind.shape()[axis]);
    let here = atom.term.shape[axis];
    let to = |x: f64| if log { x.ln() } else { x };
    let near = 1e-6 * (to(high) - to(low));
    to(here) - to(low) <= near || to(high) - to(here) <= near
}

/// Change of the prediction per unit of a shape parameter; none where there is none.
fn slope(search: &Search, found: &Hypothesis, i: usize, axis: usize) -> Option<Vec<f64>> {
    let atom = &found.atoms[i];
    let (low, high, _) = search.scales.range(&atom.term.kind.shape()[axis]);
    let here = atom.term.shape[axis];
    let step = (0.02 * here.abs()).max(1e-4 * (high - low));
    let side = |sign: f64| -> Option<Vec<f64>> {
        let mut term = atom.term;
        term.shape[axis] = here + sign * step;
        let other = Atom::new(search.design, &search.catalogue.baseline, term);
        let mut sum = vec![0.0; search.design.y.len()];
        for (c, column) in found.coefficients(search.design, i).iter().zip(other.columns.iter()) {
            for (s, x) in sum.iter_mut().zip(column.iter()) {
                *s += c * x;
            }
        }
        (other.active == atom.active).then_some(sum)
    };
    let slope: Vec<f64> = side(1.0)?.iter().zip(side(-1.0)?).map(|(a, b)| (a - b) / (2.0 * step)).collect();
    (dot(&slope, &slope) > 0.0).then_some(slope)
}
