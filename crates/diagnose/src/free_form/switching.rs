//! A force that comes and goes (a fan, a brake, a hand): several changes of one thing, none of which explains much alone. Over
//! the time a smooth curve cannot follow them, and what repeats too seldom is no hum.
//!
//! The moments belong to the recording and not to the machine.

use crate::free_form::candidate::Candidate;
use crate::free_form::change::{best, from, inner, kinds, moment_of, within};
use crate::free_form::describe::{Described, Gain};
use crate::free_form::term::FreeTerm;
use crate::library::design_matrix::DesignMatrix;
use crate::regression::linear::fit;
use crate::search::hypothesis::Hypothesis;
use crate::search::judgement::{LEVEL, Search};
use friction::Factor;
use signals::{Basis, dot};
use std::sync::Arc;

/// Most changes.
const MOST: usize = 12;
/// Blocks between two changes at least. Of what lasts as long, something is left beside a block that is held out and its neighbours.
const APART: usize = 4;
/// Smallest share of what the changes before leave that the next has to explain.
const NEXT: f64 = 0.03;
/// Smallest share of the squared error that all of them together have to explain. A floor does not judge them: where the motion
/// repeats, what comes and goes is part of it.
const MATERIAL: f64 = 0.5;

/// Rows from which on what `column` holds is another, each the best beside those before, in order of time.
fn moments(design: &DesignMatrix, found: &Hypothesis, column: &[f64]) -> Option<Vec<usize>> {
    let (inner, edges) = (inner(design)?, &design.blocks.edges);
    let block = |row: usize| edges.partition_point(|e| *e <= row);
    let mut basis = Basis::of(&found.all_columns(design));
    let mut residual = basis.project_out(&design.y);
    let mut rows: Vec<usize> = Vec::new();
    while rows.len() < MOST {
        let apart = |row: usize| rows.iter().all(|other| block(row).abs_diff(block(*other)) >= APART);
        let Some(row) = best(column, &basis, &residual, |row| within(inner, row) && apart(row)) else {
            break;
        };
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

/// The changes of one thing as free forms beside `found`.
fn changes(search: &Search, found: &Hypothesis, factor: Factor, rows: &[usize]) -> Option<Described> {
    let design = search.design;
    let mut basis = Basis::of(&found.all_columns(design));
    let mut terms = Vec::new();
    for row in rows {
        let form = Candidate::change(moment_of(design, *row), factor).form(design, 2, 0)?;
        let term = FreeTerm::new(&basis, form, Arc::new(design.free_columns(&form)))?;
        term.columns.iter().for_each(|c| {
            basis.push(c);
        });
        terms.push(term);
    }
    let all = terms.iter().flat_map(|t| t.columns.iter()).map(Vec::as_slice);
    let columns: Vec<&[f64]> = found.all_columns(design).into_iter().chain(all).collect();
    // groups of blocks are longer than what comes and goes
    let single = |columns: &[&[f64]]| fit(columns, &design.y, &design.blocks, design.blocks.len());
    let (without, fit) = (single(&found.all_columns(design))?, single(&columns)?);
    let (before, after) = (without.heldout_sum(), fit.heldout_sum());
    let gain = Gain { before, after, interval: search.gains(&without, &fit), p: 1.0 };
    Some(Described { gains: vec![gain; terms.len()], terms, fit })
}

/// What comes and goes beside `found`, for an error that nothing else explains. All gains are that of the whole. None where the
/// body only advances: its speed changes in steps then, or the place does, and each looks like a moment.
pub fn switching(search: &Search, found: &Hypothesis) -> Option<Described> {
    let design = search.design;
    if design.is_one_way() {
        return None;
    }
    let mut tried: Vec<Vec<f64>> = Vec::new();
    let mut out: Vec<(Described, Vec<Vec<f64>>)> = Vec::new();
    for (factor, column) in kinds(design) {
        tried.extend(inner(design)?.iter().step_by(2).map(|edge| from(&column, *edge)));
        let Some(rows) = moments(design, found, &column) else { continue };
        let own = rows.iter().map(|row| from(&column, *row)).collect();
        out.extend(changes(search, found, factor, &rows).map(|described| (described, own)));
    }
    let (mut best, own) =
        out.into_iter().min_by(|a, b| a.0.fit.heldout_sum().total_cmp(&b.0.fit.heldout_sum()))?;
    let basis = Basis::of(&found.all_columns(design));
    let columns = own.iter().map(|c| (true, c)).chain(tried.iter().map(|c| (false, c)));
    let (is_own, family) =
        search.family(&basis, &found.fit, &best.fit, columns.map(|(o, c)| (o, c.as_slice())).collect());
    let p = is_own.into_iter().zip(family.p).filter(|(own, _)| *own).map(|(_, p)| p).fold(1.0, f64::min);
    best.gains.iter_mut().for_each(|gain| gain.p = p);
    let gain = *best.gains.first()?;
    // the interval of the gain is not asked: it says what another recording would gain, and there the moments are others
    let clear = p <= LEVEL
        && gain.before - gain.after >= MATERIAL * gain.before
        && search.physical(&best.beside(found));
    clear.then(|| {
        best.settle(design, found);
        best
    })
}
