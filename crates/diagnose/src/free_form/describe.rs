//! The search for free forms: the one that predicts best what it was not fitted on, then the next.

use crate::free_form::candidate::{Candidate, Fineness, Library};
use crate::free_form::change::Changes;
use crate::free_form::crossing;
use crate::free_form::term::{Directions, FreeTerm, Shared};
use crate::library::baseline;
use crate::library::design_matrix::DesignMatrix;
use crate::regression::linear::{Blocks, FOLDS, Fit, Normals};
use crate::search::hypothesis::Hypothesis;
use crate::search::judgement::{LEVEL, Search};
use crate::search::lasting::{self, Regime};
use friction::{Coordinate, FreeForm};
use rayon::prelude::*;
use signals::{Basis, dot};
use std::sync::Arc;

/// Most free forms.
const MOST: usize = 3;
/// Memories between one of the library and the next, as shares of it.
const AROUND: [f64; 4] = [0.56, 0.75, 1.33, 1.78];
/// Candidates that are tried finer and coarser, and the best map: at first a map is coarse.
const CLOSER: usize = 3;
/// Relative increase of the held-out error that is accepted for fewer columns, or for a memory of the library.
const SIMPLER: f64 = 0.02;
/// Share of the gain that a map has to gain beyond a curve: it has the curve in it.
const OF_MAP: f64 = 0.01;
/// Smallest gain of a form, as a share of the error above the floor.
const MATERIAL: f64 = 0.1;
/// The same, as a share of the floor.
const SEEN: f64 = 0.05;
/// The same, as a share of what the named effects explain. Their regressors are only as exact as the measured motion, so
/// each leaves a small error of its own, which is no further physics.
const OF_NAMED: f64 = 5e-4;
/// Largest share of the squared error that one change leaves whose gain differs much from part to part of the recording.
const STEPS: f64 = 0.5;
/// Squared error over that of the floor from which on so much is left that names may be wrong, and that a map is tried: it
/// follows the small errors of the measured motion, too.
pub const LEAVES: f64 = 2.0;

/// Free forms beside a hypothesis, all fitted jointly.
#[derive(Debug, Clone)]
pub struct Described {
    pub terms: Vec<FreeTerm>,
    /// Coefficients of the baseline, of the atoms, then of the forms.
    pub fit: Fit,
    /// Of each form: held-out squares without it, with it, the 95 % interval of the gain, its p value.
    pub gains: Vec<Gain>,
}

/// What a free form gains on blocks that it was not fitted on.
#[derive(Debug, Clone, Copy)]
pub struct Gain {
    pub before: f64,
    pub after: f64,
    pub interval: [f64; 2],
    pub p: f64,
}

/// Joint fit of a hypothesis and free forms, cross-validated.
pub fn joint(design: &DesignMatrix, found: &Hypothesis, terms: &[FreeTerm]) -> Option<Fit> {
    let own = terms.iter().flat_map(|t| t.columns.iter()).map(Vec::as_slice);
    let columns: Vec<&[f64]> = Hypothesis::columns(design, &found.atoms).into_iter().chain(own).collect();
    let penalties = Hypothesis::penalties(design, &found.atoms, terms);
    let (y, blocks) = (&design.y, blocks(design, terms.iter().map(|t| &t.form)));
    let folds = folds(&blocks, terms.iter().map(|t| &t.form));
    Normals::of(&columns, y, &blocks)?.fit(&columns, &penalties, y, &blocks, folds)
}

/// Groups of blocks that are left out in turn. Of the time each is one block: what comes and goes within a longer group is not
/// known from what is around it.
fn folds<'a>(blocks: &Blocks, forms: impl IntoIterator<Item = &'a FreeForm<f64>>) -> usize {
    if forms.into_iter().any(FreeForm::is_of_time) { blocks.len() } else { FOLDS }
}

/// The blocks of a fit with these forms. A form of the acceleration has the errors of the mass's column, and to take them off
/// one of the two alone makes them cancel each other.
fn blocks<'a>(design: &DesignMatrix, forms: impl IntoIterator<Item = &'a FreeForm<f64>>) -> Blocks {
    let accelerates = |f: &FreeForm<f64>| f.reads(Coordinate::Acceleration);
    match forms.into_iter().any(accelerates) {
        true => Blocks { noise: Vec::new(), ..design.blocks.clone() },
        false => design.blocks.clone(),
    }
}

/// Everything that free forms explain beside `found`.
pub fn describe(search: &Search, library: &Library, found: &Hypothesis, regimes: &[Regime]) -> Described {
    let design = search.design;
    let mut out = Described::nothing(found);
    let explained = Hypothesis::new(design, Vec::new())
        .map_or(0.0, |baseline| baseline.fit.heldout_sum() - found.fit.heldout_sum());
    while out.terms.len() < MOST {
        let Some((term, gain, fit)) = next(search, library, found, explained, &out, regimes) else { break };
        out.terms.push(term);
        out.gains.push(gain);
        out.fit = fit;
        out = out.without_needless(search, found);
    }
    out.settle(design, found);
    out
}

impl Described {
    /// No form beside a hypothesis.
    pub fn nothing(found: &Hypothesis) -> Self {
        Self { terms: Vec::new(), fit: found.fit.clone(), gains: Vec::new() }
    }

    /// Refits the forms jointly with `found`, leaving out the form at index `drop`. None where a gain of `found` would leave
    /// the range that its effect accepts.
    pub fn without(&self, search: &Search, found: &Hypothesis, drop: Option<usize>) -> Option<Self> {
        let design = search.design;
        let mut basis = Basis::of(&Hypothesis::columns(design, &found.atoms));
        let (mut terms, mut gains) = (Vec::new(), Vec::new());
        for (i, (term, gain)) in self.terms.iter().zip(&self.gains).enumerate() {
            if drop == Some(i) {
                continue;
            }
            let anew = term.outside(&basis)?;
            anew.columns.iter().for_each(|c| {
                basis.push(c);
            });
            terms.push(anew);
            gains.push(*gain);
        }
        let fit = joint(design, found, &terms)?;
        let mut out = Self { terms, fit, gains };
        out.settle(design, found);
        search.physical(&out.beside(found)).then_some(out)
    }

    /// Drops every form that the last one replaces: a map over the time follows in part what one step explains.
    fn without_needless(self, search: &Search, found: &Hypothesis) -> Self {
        let heldout = |d: &Self| d.fit.heldout_sum();
        let before_last = 0..self.terms.len() - 1;
        let fewer = before_last.filter_map(|i| self.without(search, found, Some(i)));
        let best = fewer.min_by(|a, b| heldout(a).total_cmp(&heldout(b)));
        match best {
            Some(fewer) if heldout(&fewer) <= (1.0 + SIMPLER) * heldout(&self) => {
                fewer.without_needless(search, found)
            }
            _ => self,
        }
    }

    /// Measures again what each form gains beside `found` and the other forms.
    pub fn measured(mut self, search: &Search, found: &Hypothesis) -> Self {
        for i in 0..self.terms.len() {
            let Some(fewer) = self.without(search, found, Some(i)) else { continue };
            let (before, after) = (fewer.fit.heldout_sum(), self.fit.heldout_sum());
            let interval = search.gains(&fewer.fit, &self.fit);
            self.gains[i] = Gain { before, after, interval, ..self.gains[i] };
        }
        self
    }

    /// The hypothesis with its forms.
    pub fn beside(&self, found: &Hypothesis) -> Hypothesis {
        Hypothesis { atoms: found.atoms.clone(), free: self.terms.clone(), fit: self.fit.clone() }
    }

    /// Gives each form the values of the joint fit.
    pub fn settle(&mut self, design: &DesignMatrix, found: &Hypothesis) {
        let mut from = Hypothesis::columns(design, &found.atoms).len();
        for term in &mut self.terms {
            let own = from..from + term.columns.len();
            from = own.end;
            *term = term.clone().fitted(&self.fit.coefficients[own.clone()], &self.fit.std_errors()[own]);
        }
    }
}

/// A candidate, how fine it is, and how it does.
struct Trial {
    candidate: Candidate,
    knots: (usize, usize),
    term: FreeTerm,
    fit: Fit,
    /// Family-wise p, of the candidate that it is a refinement of.
    p: f64,
}

/// The next form; `explained` is the squared error that the named effects explain.
fn next(
    search: &Search,
    library: &Library,
    found: &Hypothesis,
    explained: f64,
    so_far: &Described,
    regimes: &[Regime],
) -> Option<(FreeTerm, Gain, Fit)> {
    let design = search.design;
    let mut columns = Hypothesis::columns(design, &found.atoms);
    columns.extend(so_far.terms.iter().flat_map(|t| t.columns.iter()).map(Vec::as_slice));
    let basis = Basis::of(&columns);
    let rows = design.used_rows();
    // the difference of two memories of nearly one length is a derivative, of any size
    let remembers =
        |c: &Candidate, f: &FreeForm<f64>| f.over == c.over && f.times == c.times && f.memory != c.memory;
    let penalties_so_far = Hypothesis::penalties(design, &found.atoms, &so_far.terms);
    let with = |candidate: Candidate, knots: (usize, usize), freedom: &[usize]| -> Option<Vec<Trial>> {
        if so_far.terms.iter().any(|t| remembers(&candidate, &t.form)) {
            return None;
        }
        let (form, all) = library.get(design, candidate, knots.0, knots.1)?;
        let directions = Directions::new(&basis, form, all)?;
        let forms = || so_far.terms.iter().map(|t| &t.form).chain([&form]);
        let blocks = blocks(design, forms());
        let folds = folds(&blocks, forms());
        // smoothing splines of one fineness differ in their penalties only
        let mut shared: Option<(Shared, Arc<Normals>)> = None;
        let mut one = |freedom: &usize| -> Option<Trial> {
            let term = directions.term(*freedom);
            let all: Vec<&[f64]> =
                columns.iter().copied().chain(term.columns.iter().map(Vec::as_slice)).collect();
            let normals = match shared.take() {
                Some((columns, normals)) if Arc::ptr_eq(&columns, &term.columns) => normals,
                _ => Normals::of(&all, &design.y, &blocks)?,
            };
            shared = Some((term.columns.clone(), normals.clone()));
            let penalties = [&penalties_so_far[..], &term.penalties].concat();
            let fit = normals.fit(&all, &penalties, &design.y, &blocks, folds)?;
            Some(Trial { candidate, knots, term, fit, p: 1.0 })
        };
        Some(freedom.iter().filter(|f| 20 * **f <= rows).filter_map(&mut one).collect())
    };
    let trials_of =
        |candidate: Candidate, of: Fineness| with(candidate, of.knots, of.freedom).into_iter().flatten();
    let before = so_far.fit.heldout_sum();
    let much = before > LEAVES * search.floor;
    let is_tried = |c: &&Candidate| much || c.across.is_none();
    let changes = Changes::new(design, &basis, &so_far.fit.residual);
    let mut trials: Vec<Trial> = library
        .candidates
        .par_iter()
        .filter(is_tried)
        .chain(&changes.candidates)
        .copied()
        .flat_map_iter(|c| c.ladder(much).first.iter().flat_map(move |f| trials_of(c, *f)))
        .collect();
    let heldout = |t: &Trial| t.fit.heldout_sum();
    trials.sort_by(|a, b| heldout(a).total_cmp(&heldout(b)));
    let p = significance(search, &so_far.fit, &trials, &changes.others, &basis)?;
    trials.iter_mut().zip(p).for_each(|(t, p)| t.p = p);
    let trials = best_of_each(trials);
    // a change has no other knots, and takes no place of a curve that has
    let (changes, mut trials): (Vec<Trial>, Vec<Trial>) =
        trials.into_iter().partition(|t| t.candidate.change.is_some());
    let map = trials.iter().position(|t| t.candidate.across.is_some());
    let closest = |i: &usize| *i < CLOSER || Some(*i) == map;
    let refined = |i: usize| {
        let Trial { candidate, p, .. } = trials[i];
        let finer = candidate.ladder(much).besides.par_iter();
        finer.flat_map_iter(move |fineness| trials_of(candidate, *fineness)).map(move |t| Trial { p, ..t })
    };
    let closest: Vec<usize> = (0..trials.len()).filter(closest).collect();
    let finer: Vec<Trial> = closest.into_par_iter().flat_map(refined).collect();
    trials.truncate(CLOSER);
    trials.extend(finer);
    trials.extend(changes);
    let material = (MATERIAL * (before - search.floor))
        .max(SEEN * search.floor)
        .max(search.systematic)
        .max(OF_NAMED * explained);
    let opposes = |fit: &Fit| baseline::opposes(&design.physics(&fit.coefficients), search.scales.speed);
    // one after the other, until one holds where it was not fitted
    while let Some(chosen) = simplest(&mut trials, before) {
        let (of, p) = (chosen.candidate, chosen.p);
        let other = |c: Candidate| with(c, chosen.knots, &[chosen.term.freedom]).into_iter().flatten();
        let others: Vec<Trial> = around(&chosen).into_par_iter().flat_map_iter(other).collect();
        let nearer = |a: &Trial, b: &Trial| heldout(b) < (1.0 - SIMPLER) * heldout(a);
        let chosen = others.into_iter().fold(chosen, |a, b| if nearer(&a, &b) { b } else { a });
        let after = heldout(&chosen);
        let interval = search.gains(&so_far.fit, &chosen.fit);
        // a form that flips the sign of a named effect replaces it instead of adding to it
        let beside = Hypothesis { fit: chosen.fit.clone(), ..found.clone() };
        // the interval says what another motion would gain, and there nothing changes at this moment
        let gains = interval[0] > 0.0
            || search.explains_several_parts(&so_far.fit, &chosen.fit)
            || of.change.is_some() && after <= STEPS * before;
        let clear = p <= LEVEL
            && gains
            && before - after >= material
            && search.physical(&beside)
            && (opposes(&chosen.fit) || !opposes(&so_far.fit));
        let holds = || {
            (chosen.term.is_of_time() || lasts(search, &basis, &chosen, regimes))
                && crossing::holds(design, &chosen.candidate, &basis, &chosen.term)
        };
        if clear && holds() {
            return Some((chosen.term, Gain { before, after, interval, p }, chosen.fit));
        }
        trials.retain(|t| t.candidate != of);
    }
    None
}

/// The best trial of each candidate, in order of what they predict, with the smallest p of its trials.
fn best_of_each(trials: Vec<Trial>) -> Vec<Trial> {
    let mut out: Vec<Trial> = Vec::new();
    for trial in trials {
        match out.iter_mut().find(|t| t.candidate == trial.candidate) {
            Some(better) => better.p = better.p.min(trial.p),
            None => out.push(trial),
        }
    }
    out
}

/// The same curve with the memories around its own; none where it has no memory.
fn around(trial: &Trial) -> Vec<Candidate> {
    let has_memory = trial.candidate.over.fades();
    let with = |share: &f64| Candidate { memory: trial.candidate.memory * share, ..trial.candidate };
    AROUND.iter().filter(|_| has_memory).map(with).collect()
}

/// Takes the simplest of the trials that are as good as the best one; `before` is the held-out error without any.
fn simplest(trials: &mut Vec<Trial>, before: f64) -> Option<Trial> {
    let heldout = |t: &Trial| t.fit.heldout_sum();
    let best = trials.iter().map(heldout).fold(f64::INFINITY, f64::min);
    let of_map =
        |t: &Trial| if t.candidate.across.is_some() { OF_MAP * (before - best).max(0.0) } else { 0.0 };
    let charged = |t: &Trial| heldout(t) + of_map(t);
    let least = trials.iter().map(charged).fold(f64::INFINITY, f64::min);
    let good = (0..trials.len()).filter(|i| charged(&trials[*i]) <= (1.0 + SIMPLER) * least);
    let first = good.min_by_key(|i| trials[*i].term.free_columns().len())?;
    Some(trials.swap_remove(first))
}

/// Family-wise p of the best column of each trial, 1 where a freer one has the same columns; `others` belong to the family and to no trial.
fn significance(
    search: &Search,
    parent: &Fit,
    trials: &[Trial],
    others: &[Vec<f64>],
    basis: &Basis,
) -> Option<Vec<f64>> {
    let child = &trials.first()?.fit;
    // of splines that share their columns the freest has those of the others
    let freest = |t: &Trial| {
        let freer =
            |o: &Trial| Arc::ptr_eq(&o.term.columns, &t.term.columns) && o.term.freedom > t.term.freedom;
        !trials.iter().any(freer)
    };
    let own = trials.iter().enumerate().filter(|(_, t)| freest(t));
    let own = own.flat_map(|(i, t)| t.term.free_columns().iter().map(move |c| (Some(i), c)));
    let columns = own.chain(others.iter().map(|c| (None, c))).map(|(i, c)| (i, c.as_slice())).collect();
    let (of, family) = search.family(basis, parent, child, columns);
    let mut out = vec![1.0_f64; trials.len()];
    for (i, p) in of.into_iter().zip(family.p).filter_map(|(i, p)| Some((i?, p))) {
        out[i] = out[i].min(p);
    }
    Some(out)
}

/// Whether it lowers the error on regimes left out.
fn lasts(search: &Search, basis: &Basis, trial: &Trial, regimes: &[Regime]) -> bool {
    let rows = search.design.used_rows().max(1) as f64;
    let noise = dot(&trial.fit.residual, &trial.fit.residual) / rows;
    let judged = lasting::left_out_errors(
        search.design,
        basis,
        &trial.term.columns,
        &trial.term.penalties,
        noise,
        regimes,
    );
    let (without, with) = judged.iter().fold((0.0, 0.0), |s, (_, e)| (s.0 + e.0, s.1 + e.1));
    judged.is_empty() || with < without
}
