//! Which way the whole force is moved in time: late or early as it is (`time_skew`, linear phase), or through a lag
//! (`actuator_lag`, bending phase).
//!
//! The two differ little below 1/(2πT), and much of what a regressor made of accelerations holds above is the sensors'
//! noise: a lag that smooths it looks better than a delay that does not. So the candidates compete on what they leave
//! *beyond the noise they carry themselves*, which one more draw of the sensors' noise measures (errors in variables
//! [fuller-1987]), with the share of the force at the 1 that physics gives it.

use crate::library::term::{Term, TermKind};
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::judgement::Search;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use signals::dot;

/// Times tried over the range, logarithmically even.
const TIMES: usize = 40;

/// Times tried to either side of one that is known, and the step from one to the next.
const NEAR: i32 = 8;
const NEARLY: f64 = 1.04;

/// Replaces a transport effect of `found` by the one, and the time, that leaves least beyond its own noise.
pub fn settle(search: &Search, found: Hypothesis) -> Hypothesis {
    replace(search, found, |_, others, corrected| best(search, others, corrected))
}

/// The same among times near the one it has.
pub fn nearby(search: &Search, found: Hypothesis) -> Hypothesis {
    let near = |term: &Term| -> Vec<Term> {
        (-NEAR..=NEAR).map(|k| term.at(term.shape[0] * NEARLY.powi(k))).collect()
    };
    replace(search, found, |term, _, corrected| lowest(search, corrected, near(term)))
}

fn replace(
    search: &Search,
    mut found: Hypothesis,
    best: impl Fn(&Term, &[Atom], &Corrected) -> Option<Term>,
) -> Hypothesis {
    for i in 0..found.atoms.len() {
        if !found.atoms[i].term.kind.moves_in_time() {
            continue;
        }
        let mut others = found.atoms.clone();
        others.remove(i);
        let own = found.atoms[i].term;
        let Some(term) = Corrected::new(search, &others).and_then(|c| best(&own, &others, &c)) else {
            continue;
        };
        let mut atom = Atom::new(search.design, &search.catalogue.baseline, term);
        atom.reliable = found.atoms[i].reliable;
        others.insert(i, atom);
        if let Some(rival) = Hypothesis::new(search.design, others).filter(|h| search.physical(h)) {
            found = rival;
        }
    }
    found
}

/// Normal equations of the baseline and some terms, with what the noise of columns and force puts into them taken out.
struct Corrected {
    columns: Vec<Vec<f64>>,
    /// What one more draw of the noise adds to each column, and to the force.
    shaken: Vec<Vec<f64>>,
    force: Vec<f64>,
    gram: Cholesky<f64, Dyn>,
}

impl Corrected {
    fn new(search: &Search, atoms: &[Atom]) -> Option<Self> {
        let (design, noisy) = (search.design, search.noisy);
        let mut columns: Vec<Vec<f64>> = design.baseline.clone();
        let mut shaken: Vec<Vec<f64>> = noisy.baseline.clone();
        for atom in atoms {
            let again = noisy.columns(&atom.term);
            columns.extend(atom.columns.iter().map(|c| c.to_vec()));
            shaken.extend(atom.active.iter().filter_map(|a| again.get(*a).cloned()));
        }
        if columns.len() != shaken.len() {
            return None;
        }
        for (again, column) in shaken.iter_mut().zip(&columns) {
            subtract(again, column);
        }
        let mut force = noisy.y.clone();
        subtract(&mut force, &design.y);
        let p = columns.len();
        let gram = DMatrix::from_fn(p, p, |i, j| dot(&columns[i], &columns[j]) - dot(&shaken[i], &shaken[j]));
        Some(Self { gram: gram.cholesky()?, columns, shaken, force })
    }

    /// What of `y` lies along each column beyond noise; `noise` is what the draw added to `y`.
    fn moment(&self, y: &[f64], noise: &[f64]) -> DVector<f64> {
        DVector::from_fn(self.columns.len(), |i, _| dot(&self.columns[i], y) - dot(&self.shaken[i], noise))
    }

    /// Coefficients of the best fit to `y`.
    fn fitted(&self, y: &[f64], noise: &[f64]) -> DVector<f64> {
        self.gram.solve(&self.moment(y, noise))
    }

    /// Squared error beyond noise of that fit.
    fn left(&self, y: &[f64], noise: &[f64]) -> f64 {
        let moment = self.moment(y, noise);
        dot(y, y) - dot(noise, noise) - moment.dot(&self.gram.solve(&moment))
    }
}

/// The share of the force that term `i` of `found` moves in time, with the noise of all columns taken out, and its
/// standard error; 1 if it is what it says.
pub fn share(search: &Search, found: &Hypothesis, i: usize) -> Option<(f64, f64)> {
    let corrected = Corrected::new(search, &found.atoms)?;
    let at = found.offset(search.design, i);
    let share = corrected.fitted(&search.design.y, &corrected.force)[at];
    let attenuated = found.coefficients(search.design, i)[0];
    Some((share, found.fit.std_errors()[at] * (share / attenuated).abs().max(1.0)))
}

/// Squared error that `child` saves beyond the noise it smooths: a load that follows slowly smooths the acceleration of
/// the drive, and is paid for it where there is no load.
pub fn saved(search: &Search, parent: &[Atom], child: &[Atom]) -> Option<f64> {
    let left = |atoms: &[Atom]| Corrected::new(search, atoms).map(|c| c.left(&search.design.y, &c.force));
    Some(left(parent)? - left(child)?)
}

/// The transport effect that leaves least beside what `corrected` holds, the `others`: none of them once more.
fn best(search: &Search, others: &[Atom], corrected: &Corrected) -> Option<Term> {
    let has = |atoms: &[Atom], kind: &TermKind| atoms.iter().any(|a| a.term.kind == *kind);
    let kinds = TermKind::all()
        .into_iter()
        .filter(|k| k.moves_in_time() && has(&search.catalogue.atoms, k) && !has(others, k));
    let mut terms = Vec::new();
    for kind in kinds {
        let (low, high, _) = search.scales.range(&kind.shape()[0]);
        for variant in 0..kind.variants().len() {
            for step in 0..TIMES {
                let time = low * (high / low).powf(step as f64 / (TIMES - 1) as f64);
                terms.push(Term { kind, shape: [time, 0.0], variant });
            }
        }
    }
    let coarse = lowest(search, corrected, terms)?;
    let (low, high, _) = search.scales.range(&coarse.kind.shape()[0]);
    let step = (high / low).powf(1.0 / (TIMES - 1) as f64);
    let fine = (-9..=9).map(|k| coarse.at(coarse.shape[0] * step.powf(f64::from(k) / 10.0)));
    lowest(search, corrected, fine.collect())
}

/// The term that leaves least beyond its own noise.
fn lowest(search: &Search, corrected: &Corrected, terms: Vec<Term>) -> Option<Term> {
    let (design, noisy) = (search.design, search.noisy);
    let left = |term: &Term| -> Option<f64> {
        let (own, mut again) = (design.columns(term).pop()?, noisy.columns(term).pop()?);
        subtract(&mut again, &own);
        let mut rest = design.y.clone();
        subtract(&mut rest, &own);
        let mut noise = corrected.force.clone();
        subtract(&mut noise, &again);
        let sum = corrected.left(&rest, &noise);
        sum.is_finite().then_some(sum)
    };
    let judged: Vec<(f64, Term)> =
        terms.into_par_iter().filter_map(|t| left(&t).map(|sum| (sum, t))).collect();
    judged.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, term)| term)
}

impl Term {
    /// The same with another time.
    fn at(&self, time: f64) -> Self {
        Self { shape: [time, 0.0], ..*self }
    }
}

fn subtract(from: &mut [f64], what: &[f64]) {
    for (x, y) in from.iter_mut().zip(what) {
        *x -= y;
    }
}
