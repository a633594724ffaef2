//! Which way the whole force is moved in time: late or early as it is (`time_skew`, linear phase), or through a lag
//! (`actuator_lag`, bending phase).
//!
//! The two differ little below 1/(2πT), and much of what a regressor made of accelerations holds above is the sensors'
//! noise: a lag that smooths it looks better than a delay that does not. So the candidates compete on what they leave
//! *beyond the noise they carry themselves*, which one more draw of the sensors' noise measures (errors in variables,
//! Fuller 1987), with the share of the force at the 1 that physics gives it.

use crate::linear::dot;
use crate::search::{Atom, Hypothesis, Search};
use crate::sensor::is_transport;
use crate::term::{Term, TermKind};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Times tried over the range, logarithmically even.
const TIMES: usize = 40;

/// Replaces a transport effect of `found` by the one, and the time, that leaves least beyond its own noise.
pub fn settle(search: &Search, mut found: Hypothesis) -> Hypothesis {
    for i in 0..found.atoms.len() {
        if !is_transport(found.atoms[i].term.kind.id()) {
            continue;
        }
        let mut others = found.atoms.clone();
        others.remove(i);
        let Some(term) = best(search, &others) else { continue };
        let mut atom = Atom::new(search.stage, &search.catalogue.baseline, term);
        atom.reliable = found.atoms[i].reliable;
        others.insert(i, atom);
        if let Some(rival) = Hypothesis::new(search.stage, others).filter(|h| search.physical(h)) {
            found = rival;
        }
    }
    found
}

/// The transport effect that leaves least beside `others`.
fn best(search: &Search, others: &[Atom]) -> Option<Term> {
    let (stage, noisy) = (search.stage, search.noisy);
    let mut columns: Vec<Vec<f64>> = stage.baseline.clone();
    let mut shaken: Vec<Vec<f64>> = noisy.baseline.clone();
    if columns.len() != shaken.len() {
        return None;
    }
    for atom in others {
        let again = noisy.columns(&atom.term);
        columns.extend(atom.columns.iter().cloned());
        shaken.extend(atom.active.iter().filter_map(|a| again.get(*a).cloned()));
    }
    // what the draw adds to each column, and to the force: noise by itself
    let p = columns.len();
    for (again, column) in shaken.iter_mut().zip(&columns) {
        subtract(again, column);
    }
    let force: Vec<f64> = noisy.y.iter().zip(&stage.y).map(|(n, y)| n - y).collect();
    let gram = DMatrix::from_fn(p, p, |i, j| dot(&columns[i], &columns[j]) - dot(&shaken[i], &shaken[j]));
    let gram = gram.cholesky()?;
    let left = |term: &Term| -> Option<f64> {
        let (own, mut again) = (stage.columns(term).pop()?, noisy.columns(term).pop()?);
        subtract(&mut again, &own);
        let mut rest = stage.y.clone();
        subtract(&mut rest, &own);
        let mut noise = force.clone();
        subtract(&mut noise, &again);
        let moment = DVector::from_fn(p, |i, _| dot(&columns[i], &rest) - dot(&shaken[i], &noise));
        let sum = dot(&rest, &rest) - dot(&noise, &noise) - moment.dot(&gram.solve(&moment));
        sum.is_finite().then_some(sum)
    };
    let kinds = TermKind::all()
        .into_iter()
        .filter(|k| is_transport(k.id()) && search.catalogue.atoms.iter().any(|a| a.term.kind == *k));
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
    let lowest = |terms: Vec<Term>| {
        let judged: Vec<(f64, Term)> =
            terms.into_par_iter().filter_map(|t| left(&t).map(|sum| (sum, t))).collect();
        judged.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (_, coarse) = lowest(terms)?;
    let (low, high, _) = search.scales.range(&coarse.kind.shape()[0]);
    let step = (high / low).powf(1.0 / (TIMES - 1) as f64);
    let fine = (-9..=9).map(|k| {
        let time = coarse.shape[0] * step.powf(f64::from(k) / 10.0);
        Term { shape: [time, 0.0], ..coarse }
    });
    lowest(fine.collect()).map(|(_, term)| term)
}

fn subtract(from: &mut [f64], what: &[f64]) {
    for (x, y) in from.iter_mut().zip(what) {
        *x -= y;
    }
}
