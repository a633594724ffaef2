//! A force that is switched on and off (a fan, a brake, a hand): several changes of one thing, none of which explains much alone.
//! A smooth curve over time does not follow the steps, and a hum needs ten periods.
//!
//! The moments belong to the recording and not to the machine.

use crate::findings::locate::row_times;
use crate::free_form::candidate::Candidate;
use crate::free_form::change::{at_other_moments, best, from, inner, kinds, moment_of};
use crate::free_form::describe::{Described, Gain, joint};
use crate::free_form::term::{Directions, FreeTerm};
use crate::library::design_matrix::DesignMatrix;
use crate::search::hypothesis::Hypothesis;
use crate::search::judgement::{LEVEL, Search};
use friction::Factor;
use signals::{Basis, dot};
use std::sync::Arc;

/// Most changes.
const MOST: usize = 12;
/// Smallest distance between two changes, in blocks. Cross-validation leaves out three in a row, a block and its guards: the
/// level between the changes needs a fourth to be fitted to.
const APART: usize = 4;
/// Smallest share of what the changes before leave that the next has to explain.
const NEXT: f64 = 0.03;
/// Smallest share of the squared error that all of them together have to explain. A floor does not judge them: where the motion
/// repeats, what comes and goes is part of it.
const MATERIAL: f64 = 0.5;

/// Rows from which on what `column` holds is another, each the best beside `basis` and those before, in order of time.
fn moments(design: &DesignMatrix, mut basis: Basis, column: &[f64], inner: &[usize]) -> Option<Vec<usize>> {
    let block = |row: usize| design.blocks.edges.partition_point(|e| *e <= row);
    let mut residual = basis.project_out(&design.y);
    let mut rows: Vec<usize> = Vec::new();
    while rows.len() < MOST {
        let apart = |row: usize| rows.iter().all(|other| block(row).abs_diff(block(*other)) >= APART);
        let Some(row) = best(column, &basis, &residual, inner, apart) else { break };
        if !basis.push(&from(column, row)) {
            break;
        }
        let left = basis.project_out(&design.y);
        if dot(&left, &left) > (1.0 - NEXT) * dot(&residual, &residual) {
            break;
        }
        residual = left;
        rows.push(row);
    }
    rows.sort_unstable();
    (rows.len() > 1).then_some(rows)
}

/// The changes of one thing as free forms outside `basis`.
fn forms(design: &DesignMatrix, mut basis: Basis, factor: Factor, rows: &[usize]) -> Option<Vec<FreeTerm>> {
    let times = row_times(design);
    let form = |row: &usize| {
        let form = Candidate::change(moment_of(design, &times, *row), factor).form(design, 2, 0)?;
        let all = Arc::new(design.free_columns(&form));
        let term = Directions::new(&basis, form, all)?.term(form.count());
        term.columns.iter().for_each(|c| {
            basis.push(c);
        });
        Some(term)
    };
    rows.iter().map(form).collect()
}

/// What comes and goes beside `found`, for an error that nothing else explains. All gains are that of the whole. None where the
/// body only advances: its speed changes in steps then, or the place does, and each looks like a moment.
pub fn switching(search: &Search, found: &Hypothesis) -> Option<Described> {
    let design = search.design;
    if design.is_one_way() {
        return None;
    }
    let inner = inner(design)?;
    let kinds = kinds(design);
    let basis = Basis::of(&found.all_columns(design));
    let (fit_with, terms, column, rows) = kinds
        .iter()
        .filter_map(|(factor, column)| {
            let rows = moments(design, basis.clone(), column, inner)?;
            let terms = forms(design, basis.clone(), *factor, &rows)?;
            Some((joint(design, found, &terms)?, terms, column, rows))
        })
        .min_by(|a, b| a.0.heldout_sum().total_cmp(&b.0.heldout_sum()))?;
    let own: Vec<Vec<f64>> = rows.iter().map(|row| from(column, *row)).collect();
    let others: Vec<Vec<f64>> =
        kinds.iter().flat_map(|(_, column)| at_other_moments(column, inner)).collect();
    let columns =
        own.iter().map(|c| (true, c.as_slice())).chain(others.iter().map(|c| (false, c.as_slice())));
    let (is_own, family) = search.family(&basis, &found.fit, &fit_with, columns.collect());
    let p = is_own.into_iter().zip(family.p).filter(|(own, _)| *own).map(|(_, p)| p).fold(1.0, f64::min);
    let (before, after) = (found.fit.heldout_sum(), fit_with.heldout_sum());
    let gain = Gain { before, after, interval: search.gains(&found.fit, &fit_with), p };
    let mut described = Described { gains: vec![gain; terms.len()], terms, fit: fit_with };
    // the interval of the gain is not asked: it says what another recording would gain, and there the moments are others
    let clear =
        p <= LEVEL && before - after >= MATERIAL * before && search.physical(&described.beside(found));
    clear.then(|| {
        described.settle(design, found);
        described
    })
}
