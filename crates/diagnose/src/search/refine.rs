//! Shapes of all terms at once: variable projection (Golub and Pereyra 1973, with Kaufman's Jacobian of 1975), damped
//! after Levenberg and Marquardt, repeated until it stands still.
//!
//! Gains of a force have a weak prior, normal with the recording's own rms force: where only the product of a gain and
//! a shape shows (a rest time far beyond every rest, a speed far beyond every speed) it keeps the gain from running
//! along the ridge to forces that were never there. Where the recording says anything itself, the prior weighs nothing.

use crate::library::kept::Column;
use crate::regression::linear::{gram, inverse};
use crate::search::catalogue::is_testable;
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::judgement::Search;
use friction::Dimension;
use friction::effects::{MAX_SHAPE, Scale};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use signals::{dot, subtract_scaled};

/// Damping of its own above which an axis is held for a step.
const HELD: f64 = 1e4;

/// Share of a squared slope below which what the gains leave of it is rounding.
const ROUNDING: f64 = 1e-12;

/// Times by which a refinement may do better than its slopes promise.
const HOPE: f64 = 4.0;

/// How far a refinement goes.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Most steps.
    steps: usize,
    /// Change of the squared error, in squares of the noise of one row, that counts as standing still.
    still: f64,
    /// Distance from where a slope was taken, in the longest steps of its axis, up to which it stands for the slope here.
    fresh: f64,
}

/// While hypotheses compete: to a standard deviation of a parameter.
pub const ROUGH: Effort = Effort { steps: 6, still: 1.0, fresh: 0.1 };
/// For the hypothesis that is left: to a tenth of a standard deviation.
pub const FINE: Effort = Effort { steps: 40, still: 0.01, fresh: 0.01 };

/// One shape parameter that is free.
#[derive(Debug, Clone, Copy)]
struct Axis {
    atom: usize,
    index: usize,
    low: f64,
    high: f64,
    log: bool,
    /// Longest step, in the parameter or its logarithm: what the grid left open.
    reach: f64,
}

impl Axis {
    fn to(self, value: f64) -> f64 {
        if self.log { value.ln() } else { value }
    }

    fn moved(self, value: f64, by: f64) -> f64 {
        let at = self.to(value) + by.clamp(-self.reach, self.reach);
        if self.log { at.exp() } else { at }.clamp(self.low, self.high)
    }
}

/// A set of atoms and what they leave.
struct Point {
    atoms: Vec<Atom>,
    gains: Vec<f64>,
    /// Inverse of the columns' inner products, with the prior of the gains.
    cover: DMatrix<f64>,
    residual: Vec<f64>,
    /// Squared residual, with what the prior asks for.
    squared: f64,
    /// All effects are distinct, and every gain is within its effect's range.
    physical: bool,
}

/// What the columns of an atom change per unit of an axis.
struct Slope {
    /// Where it was taken.
    shape: [f64; MAX_SHAPE],
    columns: Vec<Vec<f64>>,
}

impl Search<'_> {
    /// Improves all shapes of a hypothesis jointly.
    pub fn refine(&self, hypothesis: Hypothesis, effort: Effort) -> Hypothesis {
        self.refine_by(hypothesis, effort, 0.0)
    }

    /// The same for a hypothesis that is of use only if its squared error falls by `needed`: given up where
    /// [`HOPE`] times what the slopes promise would not do.
    pub fn refine_by(&self, hypothesis: Hypothesis, effort: Effort, needed: f64) -> Hypothesis {
        let axes = self.axes(&hypothesis);
        if axes.is_empty() {
            return hypothesis;
        }
        let Some(mut here) = self.point(hypothesis.atoms.clone()) else { return hypothesis };
        let begun = here.squared;
        let still = effort.still * self.row_noise();
        let mut known: Vec<Option<Slope>> = axes.iter().map(|_| None).collect();
        let mut damping = 1e-3;
        // beside it, of the axes of terms that a step took to where they cannot be seen
        let mut own = vec![0.0_f64; axes.len()];
        for _ in 0..effort.steps {
            let Some((normal, moment)) = self.slopes(&here, &axes, effort.fresh, &mut known) else { break };
            let p = axes.len();
            let before = here.squared;
            let undamped = step(&normal, &moment, &vec![1e-9; p], |_, _| false);
            let best = undamped.map_or(f64::INFINITY, |step| promised(&normal, &moment, &step));
            if begun - here.squared + HOPE * best < needed {
                return hypothesis;
            }
            while damping < 1e5 {
                let stays = |i: usize, by: f64| {
                    let value = here.atoms[axes[i].atom].term.shape[axes[i].index];
                    own[i] > HELD || axes[i].moved(value, by) == value
                };
                let damped: Vec<f64> = own.iter().map(|own| damping + own).collect();
                let Some(mut step) = step(&normal, &moment, &damped, stays) else {
                    damping *= 10.0;
                    continue;
                };
                // an axis that stands still costs no column
                for (i, by) in step.iter_mut().enumerate() {
                    if *by * *by * normal[(i, i)] < 0.1 * still / p as f64 {
                        *by = 0.0;
                    }
                }
                // what does not even promise a gain that counts need not be tried
                if promised(&normal, &moment, &step) < still {
                    break;
                }
                match self.moved(&here, &axes, &step) {
                    Err(atom) => {
                        let of_atom = own.iter_mut().zip(&axes).filter(|(_, axis)| axis.atom == atom);
                        of_atom.for_each(|(own, _)| *own = (10.0 * *own).max(1.0));
                    }
                    Ok(Some(next)) if next.squared < here.squared && (next.physical || !here.physical) => {
                        here = next;
                        damping = (0.1 * damping).max(1e-9);
                        own.iter_mut().for_each(|own| *own *= 0.1);
                        break;
                    }
                    Ok(_) => damping *= 10.0,
                }
            }
            if before - here.squared < still {
                break;
            }
        }
        if here.squared >= begun {
            return hypothesis;
        }
        match Hypothesis::new(self.design, here.atoms) {
            Some(better) if self.physical(&better) || !self.physical(&hypothesis) => better,
            _ => hypothesis,
        }
    }

    /// Squared noise of one row.
    fn row_noise(&self) -> f64 {
        self.floor / self.design.effective_rows().max(1.0)
    }

    /// Shape parameters that change a column.
    fn axes(&self, hypothesis: &Hypothesis) -> Vec<Axis> {
        let mut out = Vec::new();
        for (atom, a) in hypothesis.atoms.iter().enumerate() {
            for (index, parameter) in a.term.kind.shape().iter().enumerate().take(MAX_SHAPE) {
                let (low, high, log) = self.scales.range(parameter);
                let here = a.term.shape[index];
                if !(low < high) || here <= 0.0 && log {
                    continue;
                }
                let reach = if parameter.scale == Scale::Wavelength {
                    // Lines are narrow: the grid's spacing in waves per stroke.
                    let share = (0.4 * here / (self.scales.stroke.1 - self.scales.stroke.0)).min(0.3);
                    if log { share } else { share * here }
                } else if log {
                    (high / low).ln() / 9.0
                } else {
                    (high - low) / 9.0
                };
                out.push(Axis { atom, index, low, high, log, reach });
            }
        }
        out
    }

    /// Weight of the prior of each gain, zero for gains that are no force.
    fn priors(&self, atoms: &[Atom]) -> Vec<f64> {
        let force = (dot(&self.design.y, &self.design.y) / self.design.y.len().max(1) as f64).sqrt();
        let weight = self.row_noise().sqrt() / force.max(1e-300);
        let of = |atom: &Atom| -> Vec<f64> {
            let groups = atom.term.free_gains();
            let is_force = |a: &usize| {
                let gain = groups.get(*a).and_then(|g| g.first());
                gain.is_some_and(|g| atom.term.kind.gains()[*g].dimension == Dimension::FORCE)
            };
            atom.active.iter().map(|a| if is_force(a) { weight } else { 0.0 }).collect()
        };
        let mut out = vec![0.0; self.design.baseline.len()];
        out.extend(atoms.iter().flat_map(of));
        out
    }

    fn point(&self, atoms: Vec<Atom>) -> Option<Point> {
        let columns = Hypothesis::columns(self.design, &atoms);
        let priors = self.priors(&atoms);
        let mut gram = gram(&columns, 0..self.design.y.len());
        for (i, prior) in priors.iter().enumerate() {
            gram[(i, i)] += prior * prior;
        }
        let cover = inverse(&gram)?;
        let y = &self.design.y;
        let moment = DVector::from_iterator(columns.len(), columns.iter().map(|c| dot(c, y)));
        let gains: Vec<f64> = (&cover * moment).iter().copied().collect();
        let mut residual = y.clone();
        for (gain, column) in gains.iter().zip(&columns) {
            subtract_scaled(&mut residual, *gain, column);
        }
        let asked: f64 = gains.iter().zip(&priors).map(|(g, prior)| (g * prior).powi(2)).sum();
        let squared = dot(&residual, &residual) + asked;
        let mut from = self.design.baseline.len();
        let in_range = |a: &Atom| {
            from += a.columns.len();
            a.physical(&gains[from - a.columns.len()..from])
        };
        let physical = self.are_apart(&atoms) && atoms.iter().all(in_range);
        squared.is_finite().then_some(Point { atoms, gains, cover, residual, squared, physical })
    }

    /// Inner products of what the residual loses per unit of each axis, with each other and with the residual; `known` holds
    /// slopes taken before, which stand as far as `fresh`.
    fn slopes(
        &self,
        here: &Point,
        axes: &[Axis],
        fresh: f64,
        known: &mut [Option<Slope>],
    ) -> Option<(DMatrix<f64>, DVector<f64>)> {
        axes.par_iter().zip(known.par_iter_mut()).try_for_each(|(axis, known)| {
            let shape = here.atoms[axis.atom].term.shape;
            let near = |k: &Slope| {
                let of_atom = axes.iter().filter(|other| other.atom == axis.atom);
                let mut moved =
                    of_atom.map(|o| (o.to(shape[o.index]) - o.to(k.shape[o.index])).abs() / o.reach);
                moved.all(|moved| moved <= fresh)
            };
            if !known.as_ref().is_some_and(near) {
                *known = Some(self.slope(&here.atoms[axis.atom], axis)?);
            }
            Some(())
        })?;
        let columns = Hypothesis::columns(self.design, &here.atoms);
        let change = |(axis, slope): (&Axis, &Option<Slope>)| -> Option<(Vec<f64>, DVector<f64>)> {
            let from = self.design.baseline.len()
                + here.atoms[..axis.atom].iter().map(|a| a.columns.len()).sum::<usize>();
            let mut change = vec![0.0; here.residual.len()];
            for (c, column) in here.gains[from..].iter().zip(&slope.as_ref()?.columns) {
                subtract_scaled(&mut change, -c, column);
            }
            let with = DVector::from_iterator(columns.len(), columns.iter().map(|c| dot(c, &change)));
            Some((change, with))
        };
        let changes: Vec<(Vec<f64>, DVector<f64>)> =
            axes.par_iter().zip(&*known).map(change).collect::<Option<_>>()?;
        // each change minus its projection onto the columns, from inner products alone
        let taken: Vec<DVector<f64>> = changes.iter().map(|(_, with)| &here.cover * with).collect();
        let mut normal = DMatrix::zeros(axes.len(), axes.len());
        for i in 0..axes.len() {
            for j in 0..=i {
                let whole = dot(&changes[i].0, &changes[j].0);
                let left = whole - changes[i].1.dot(&taken[j]);
                // what rounding leaves of a square may be below zero
                let left = if i == j { left.max(ROUNDING * whole) } else { left };
                (normal[(i, j)], normal[(j, i)]) = (left, left);
            }
        }
        let moment = DVector::from_iterator(axes.len(), changes.iter().map(|(c, _)| dot(c, &here.residual)));
        Some((normal, moment))
    }

    /// What the columns of an atom change per unit of an axis.
    fn slope(&self, atom: &Atom, axis: &Axis) -> Option<Slope> {
        let at = atom.term.shape[axis.index];
        let up = 0.02 * axis.reach;
        let by = if axis.to(axis.moved(at, up)) > axis.to(at) { up } else { -up };
        let other = self.reshaped(atom, &[(axis.index, axis.moved(at, by))])?;
        let change = |(near, far): (&Column, &Column)| {
            near.iter().zip(far.iter()).map(|(x, z)| (z - x) / by).collect::<Vec<f64>>()
        };
        let columns = atom.columns.iter().zip(other.columns.iter()).map(change).collect();
        Some(Slope { shape: atom.term.shape, columns })
    }

    /// An atom with other shape parameters; None where its columns are others or cannot be seen.
    fn reshaped(&self, atom: &Atom, shape: &[(usize, f64)]) -> Option<Atom> {
        let mut term = atom.term;
        for (index, value) in shape {
            term.shape[*index] = *value;
        }
        let mut other = Atom::new(self.design, &self.catalogue.baseline, term);
        other.reliable = atom.reliable;
        (other.active == atom.active && is_testable(&other)).then_some(other)
    }

    /// What a step leads to, none where the columns have become dependent.
    ///
    /// # Errors
    /// The first atom that cannot be seen there.
    fn moved(&self, here: &Point, axes: &[Axis], step: &DVector<f64>) -> Result<Option<Point>, usize> {
        let atoms: Vec<Option<Atom>> = (0..here.atoms.len())
            .into_par_iter()
            .map(|i| {
                let atom = &here.atoms[i];
                let shape: Vec<(usize, f64)> = axes
                    .iter()
                    .zip(step.iter())
                    .filter(|(a, by)| a.atom == i && **by != 0.0)
                    .map(|(a, by)| (a.index, a.moved(atom.term.shape[a.index], *by)))
                    .collect();
                if shape.is_empty() { Some(atom.clone()) } else { self.reshaped(atom, &shape) }
            })
            .collect();
        if let Some(unseen) = atoms.iter().position(Option::is_none) {
            return Err(unseen);
        }
        Ok(self.point(atoms.into_iter().flatten().collect()))
    }
}

/// What a step takes off the squared error if the prediction is as linear in the shapes as its slopes.
fn promised(normal: &DMatrix<f64>, moment: &DVector<f64>, step: &DVector<f64>) -> f64 {
    2.0 * step.dot(moment) - step.dot(&(normal * step))
}

/// A step, each axis with its own damping; None where the normal matrix is singular. An axis that the step would push out
/// of its range, where it `stays`, is left out and the others are solved for without it.
fn step(
    normal: &DMatrix<f64>,
    moment: &DVector<f64>,
    damping: &[f64],
    stays: impl Fn(usize, f64) -> bool,
) -> Option<DVector<f64>> {
    let mut free: Vec<usize> = (0..moment.len()).collect();
    loop {
        let mut damped = normal.select_rows(&free).select_columns(&free);
        for (i, axis) in free.iter().enumerate() {
            damped[(i, i)] += damping[*axis] * damped[(i, i)] + 1e-300;
        }
        let step = damped.cholesky()?.solve(&moment.select_rows(&free));
        let moving: Vec<usize> = free
            .iter()
            .zip(step.iter())
            .filter(|(axis, by)| !stays(**axis, **by))
            .map(|(axis, _)| *axis)
            .collect();
        if moving.len() == free.len() {
            let mut out = DVector::zeros(moment.len());
            for (axis, by) in free.iter().zip(step.iter()) {
                out[*axis] = *by;
            }
            return Some(out);
        }
        free = moving;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_at_the_end_of_its_range_shortened_the_steps_of_all_others() {
        let normal = DMatrix::from_row_slice(2, 2, &[1.0, 0.9, 0.9, 1.0]);
        let moment = DVector::from_column_slice(&[1.0, 0.2]);
        let free = step(&normal, &moment, &[1e-9; 2], |_, _| false).unwrap();
        assert!(free[0] > 4.0 && free[1] < -3.0, "{free}");
        // the first may not grow: the second is solved for alone, and goes the other way
        let bound = step(&normal, &moment, &[1e-9; 2], |axis, by| axis == 0 && by > 0.0).unwrap();
        assert!(bound[0] == 0.0 && (bound[1] - 0.2).abs() < 1e-6, "{bound}");
        assert!((promised(&normal, &moment, &bound) - 0.04).abs() < 1e-6);
        // nothing may move: nothing is promised
        let held = step(&normal, &moment, &[1e-9; 2], |_, _| true).unwrap();
        assert_eq!(promised(&normal, &moment, &held), 0.0);
        // damped on its own the first hardly moves and leaves the second what it would have alone
        let alone = step(&normal, &moment, &[1e3, 1e-9], |_, _| false).unwrap();
        assert!(alone[0].abs() < 1e-2 && (alone[1] - 0.2).abs() < 1e-2, "{alone}");
    }
}
