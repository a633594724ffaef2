//! Naming: a beam search over the catalogue with pair steps, each step tested against the best of a null
//! catalogue and against a bootstrap of its held-out gain, then pruned backward.

use crate::flips::{Family, Scores, block_scores, family, gain_interval};
use crate::linear::{Basis, Fit, dot, fit};
use crate::sensor::Acts;
use crate::term::{Scales, Stage, Term, TermKind, gather, is_wave};
use friction::effects::MAX_SHAPE;
use rayon::prelude::*;

/// Groups of blocks left out in turn.
pub const FOLDS: usize = 10;
/// Random signs drawn for a test, so that the smallest p value is 1/1000.
pub const FLIPS: usize = 999;
/// Family-wise level of a step.
pub const LEVEL: f64 = 0.01;
/// Cosine above which two explanations count as one on a recording.
pub const COLLINEAR: f64 = 0.95;
/// Share of an effect left outside the baseline (U) below which a recording is said to be blind to it.
pub const CONCEALED: f64 = 0.1;
/// The same for a gain of the whole force channel, below which it is not looked for: nearly all of it is friction and mass
/// of another size, and as it has no shape to choose it is found by the little that is not.
const CONCEALED_GAIN: f64 = 0.04;
/// Smallest share of the mismatch above the floor for which a term is worth naming.
const MATERIAL: f64 = 0.01;
/// Or of what the terms before it left: where a spring is nearly all of the force, what stiffens it is less than a
/// hundredth of the mismatch and nearly all of the rest.
const MOST_OF_REST: f64 = 0.5;

/// Share of what a term gains that another may lose in its place and still count as good.
const AS_GOOD: f64 = 0.03;

/// Steps of refinement while hypotheses compete, and for the one that is left.
pub const ROUGH: usize = 6;
const FINE: usize = 40;

/// A term with its columns on the stage.
#[derive(Debug, Clone)]
pub struct Atom {
    /// The hypothesis.
    pub term: Term,
    /// Columns that the baseline does not already contain.
    pub columns: Vec<Vec<f64>>,
    /// Which of the term's free gains they are.
    pub active: Vec<usize>,
    /// Share of the columns left outside the baseline, 0 = concealed on this motion.
    pub visible: f64,
    /// Share of what is left that is signal rather than sensor noise.
    pub reliable: f64,
}

impl Atom {
    /// Evaluates a term; `baseline` is a basis of the baseline's columns.
    pub fn new(stage: &Stage, baseline: &Basis, term: Term) -> Self {
        Self::of(stage.columns(&term), baseline, term)
    }

    /// The same from columns that are already there.
    fn of(all: Vec<Vec<f64>>, baseline: &Basis, term: Term) -> Self {
        let mut columns = Vec::new();
        let mut active = Vec::new();
        let mut visible: f64 = 0.0;
        for (i, column) in all.into_iter().enumerate() {
            let size = dot(&column, &column).sqrt();
            let rest = baseline.project_out(&column);
            let left = dot(&rest, &rest).sqrt();
            if size > 0.0 && size.is_finite() && left.is_finite() {
                visible = visible.max(left / size);
                if left > 1e-3 * size {
                    columns.push(column);
                    active.push(i);
                }
            }
        }
        Self { term, columns, active, visible, reliable: 1.0 }
    }

    /// What of each column is outside the span of `basis`.
    pub fn outside(&self, basis: &Basis) -> Vec<Vec<f64>> {
        self.columns.iter().map(|c| basis.project_out(c)).collect()
    }

    /// Whether gains lie in the range their effect accepts: a fit that ends outside is naming another effect.
    pub fn physical(&self, coefficients: &[f64]) -> bool {
        let gains = self.gains(coefficients);
        self.term.kind.gains().iter().zip(gains).all(|(p, g)| g.is_finite() && g >= p.min && g <= p.max)
    }

    /// The effect's gains, spread over directions, from its coefficients in a fit.
    pub fn gains(&self, coefficients: &[f64]) -> [f64; friction::effects::MAX_GAINS] {
        let mut free = vec![0.0; self.term.free_gains().len()];
        for (a, c) in self.active.iter().zip(coefficients) {
            free[*a] = *c;
        }
        self.term.spread(&free)
    }
}

/// The baseline with some terms.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// What was added.
    pub atoms: Vec<Atom>,
    /// The joint fit.
    pub fit: Fit,
}

impl Hypothesis {
    /// All columns: baseline first, then each atom's.
    pub fn columns<'a>(stage: &'a Stage, atoms: &'a [Atom]) -> Vec<&'a [f64]> {
        let own = atoms.iter().flat_map(|a| a.columns.iter());
        stage.baseline.iter().chain(own).map(Vec::as_slice).collect()
    }

    /// Fits the baseline and `atoms` jointly.
    pub fn new(stage: &Stage, atoms: Vec<Atom>) -> Option<Self> {
        let fit = fit(&Self::columns(stage, &atoms), &stage.y, &stage.blocks, FOLDS)?;
        Some(Self { atoms, fit })
    }

    /// First coefficient of atom `i`.
    pub fn offset(&self, stage: &Stage, i: usize) -> usize {
        stage.baseline.len() + self.atoms[..i].iter().map(|a| a.columns.len()).sum::<usize>()
    }

    /// Coefficients of atom `i`.
    pub fn coefficients(&self, stage: &Stage, i: usize) -> &[f64] {
        let from = self.offset(stage, i);
        &self.fit.coefficients[from..from + self.atoms[i].columns.len()]
    }

    fn has(&self, kind: TermKind) -> bool {
        self.atoms.iter().any(|a| a.term.kind == kind)
    }
}

/// The catalogue evaluated on a stage.
#[derive(Debug, Clone)]
pub struct Catalogue {
    /// Every effect at every shape of the grid.
    pub atoms: Vec<Atom>,
    /// Basis of the baseline.
    pub baseline: Basis,
}

impl Catalogue {
    /// Evaluates the catalogue over its grid; `noisy` is the same stage with one more draw of sensor noise.
    ///
    /// `lines` are wavelengths finer than the grid's that stand out of the residual.
    pub fn new(stage: &Stage, noisy: &Stage, scales: &Scales, lines: &[f64], exclude: &[&str]) -> Self {
        let baseline = Basis::of(&stage.baseline);
        let mut terms = Vec::new();
        for kind in TermKind::all() {
            if !exclude.contains(&kind.id()) {
                terms.extend(scales.grid(kind).into_iter().map(|shape| (kind, shape)));
                if kind.shape().first().is_some_and(|p| is_wave(p.name)) {
                    terms.extend(lines.iter().map(|line| (kind, [*line, 0.0])));
                }
            }
        }
        let evaluate = |(kind, shape): &(TermKind, [f64; MAX_SHAPE])| -> Vec<Atom> {
            let (clean, other) = (stage.all_columns(*kind, shape), noisy.all_columns(*kind, shape));
            let variant = |(variant, groups): (usize, &Vec<Vec<usize>>)| {
                let term = Term { kind: *kind, shape: *shape, variant };
                let mut atom = Atom::of(gather(&clean, groups), &baseline, term);
                atom.reliable = reliability(&gather(&other, groups), &baseline, &atom);
                atom
            };
            kind.variants().iter().enumerate().map(variant).collect()
        };
        // In the order of the catalogue whatever the number of workers: everything random hangs on it.
        let atoms = terms.par_iter().flat_map_iter(evaluate).collect();
        Self { atoms, baseline }
    }

    /// Evaluates what the force that acts is part of once more, on stages of which only that force is another.
    pub fn renew(&mut self, stage: &Stage, noisy: &Stage) {
        let baseline = &self.baseline;
        self.atoms.par_iter_mut().filter(|a| a.term.kind.reads_force()).for_each(|atom| {
            *atom = Atom::new(stage, baseline, atom.term);
            atom.reliable = reliability(&noisy.columns(&atom.term), baseline, atom);
        });
    }

    /// Atoms that this recording can show: visible beside the baseline, and more signal than noise.
    pub fn testable(&self) -> Vec<&Atom> {
        self.atoms.iter().filter(|a| is_testable(a)).collect()
    }
}

/// Whether an atom may be found: it stands out of the baseline at all, and above its own noise.
pub fn is_testable(atom: &Atom) -> bool {
    let least = match atom.term.kind {
        TermKind::Sensor(sensor) if sensor.shape.is_empty() => CONCEALED_GAIN,
        _ => CONCEALED,
    };
    !atom.columns.is_empty() && atom.visible >= least && atom.reliable >= needed_reliability(atom.term.kind)
}

/// Whether the recording can be relied on to show it: what is not found is not there.
pub fn is_shown(atom: &Atom) -> bool {
    is_testable(atom) && atom.visible >= CONCEALED
}

pub(crate) fn needed_reliability(kind: TermKind) -> f64 {
    // The noise of these is the acceleration's own noise seen again: it correlates with the residual.
    if kind.acts(Acts::OnMotion) {
        0.99
    } else if kind.acts(Acts::Behind) {
        0.9
    } else {
        0.7
    }
}

fn reliability(other: &[Vec<f64>], baseline: &Basis, atom: &Atom) -> f64 {
    let (mut signal, mut noise) = (0.0, 0.0);
    for (column, i) in atom.columns.iter().zip(&atom.active) {
        let Some(other) = other.get(*i) else { continue };
        let change: Vec<f64> = column.iter().zip(other).map(|(a, b)| a - b).collect();
        let (rest, change) = (baseline.project_out(column), baseline.project_out(&change));
        signal += dot(&rest, &rest);
        noise += dot(&change, &change);
    }
    if signal > 0.0 { 1.0 - noise / signal } else { 0.0 }
}

/// Settings of the search.
#[derive(Debug, Clone, Copy)]
pub struct Search<'a> {
    /// The regression.
    pub stage: &'a Stage,
    /// The same with one more draw of the sensors' noise.
    pub noisy: &'a Stage,
    /// The catalogue on it.
    pub catalogue: &'a Catalogue,
    /// Scales for refining shapes.
    pub scales: &'a Scales,
    /// Squared error that noise alone leaves.
    pub floor: f64,
    /// Squared error of the sensors that may repeat with the motion as physics does: nothing smaller is named.
    pub systematic: f64,
    /// Most terms.
    pub max_terms: usize,
    /// Hypotheses carried along.
    pub width: usize,
    /// Seed of every draw.
    pub seed: u64,
}

impl Search<'_> {
    /// The best hypothesis whose every term is significant, holds out of sample and is material.
    pub fn run(&self, progress: &dyn Fn(f32, &str)) -> Option<(Hypothesis, Vec<f64>)> {
        let baseline = Hypothesis::new(self.stage, Vec::new())?;
        let start = baseline.fit.heldout_sum();
        let mut best = baseline.clone();
        let mut beam = vec![baseline];
        while best.atoms.len() < self.max_terms {
            progress(
                0.3 + 0.5 * best.atoms.len() as f32 / self.max_terms as f32,
                &format!("naming: {} found", best.atoms.len()),
            );
            let mut next: Vec<Hypothesis> = beam.iter().flat_map(|h| self.extend(h)).collect();
            next.sort_by(|a, b| self.cost(a).total_cmp(&self.cost(b)));
            let mut kept: Vec<Hypothesis> = Vec::new();
            for h in next {
                let kinds = kinds_of(&h);
                if kept.len() < self.width && kept.iter().all(|k| kinds_of(k) != kinds) {
                    kept.push(h);
                }
            }
            kept = kept.into_par_iter().map(|h| self.refine(h, ROUGH)).collect();
            kept.sort_by(|a, b| self.cost(a).total_cmp(&self.cost(b)));
            let Some(found) = kept.iter().find(|h| self.holds(&best, h, start)) else { break };
            best = found.clone();
            beam = kept;
        }
        let best = self.refine(self.sublinear(self.plain(self.simplify(best))), FINE);
        Some(self.prune(crate::transport::settle(self, best), start))
    }

    /// Takes out of each term the gains that its recording does not ask for: the second harmonic, a second end of the
    /// stroke, a difference between the directions. A line may stand at twice its wavelength as a second harmonic.
    fn plain(&self, mut best: Hypothesis) -> Hypothesis {
        for i in 0..best.atoms.len() {
            let own = best.atoms[i].clone();
            let kind = own.term.kind;
            let mut shapes = vec![own.term.shape];
            if let Some(wave) = kind.shape().iter().position(|p| crate::term::is_wave(p.name)) {
                let mut half = own.term.shape;
                half[wave] *= 0.5;
                shapes.push(half);
            }
            let mut simpler: Vec<Hypothesis> = (0..kind.variants().len())
                .flat_map(|variant| shapes.iter().map(move |shape| Term { kind, shape: *shape, variant }))
                .filter_map(|term| {
                    let mut atom = Atom::new(self.stage, &self.catalogue.baseline, term);
                    atom.reliable = own.reliable;
                    let fewer = is_testable(&atom) && atom.columns.len() < own.columns.len();
                    let mut atoms = best.atoms.clone();
                    atoms[i] = atom;
                    fewer.then(|| Hypothesis::new(self.stage, atoms)).flatten()
                })
                .map(|h| self.refine(h, ROUGH))
                .filter(|h| self.physical(h) && self.interval(h, &best)[0] <= 0.0)
                .collect();
            let size = |h: &Hypothesis| h.atoms[i].columns.len();
            simpler.sort_by(|a, b| {
                size(a).cmp(&size(b)).then(a.fit.heldout_sum().total_cmp(&b.fit.heldout_sum()))
            });
            if let Some(first) = simpler.into_iter().next() {
                best = first;
            }
        }
        best
    }

    /// Replaces each term, and each two, by the simplest one that explains this recording as well: a spring rather than
    /// friction that depends on position with opposite slopes for the two directions, a hardening spring rather than a
    /// spring and a pendulum against it.
    fn simplify(&self, mut best: Hypothesis) -> Hypothesis {
        let count = best.atoms.len();
        for i in 0..count {
            if let Some(rival) = self.simpler(&best, &[i]) {
                best = rival;
            }
        }
        for pair in (0..count).flat_map(|i| (i + 1..count).map(move |j| [i, j])) {
            if let Some(rival) = self.simpler(&best, &pair) {
                return self.simplify(rival);
            }
        }
        best
    }

    /// Puts `stribeck` in the place of a `sublinear_viscous` that is not: with a power above 1 friction grows faster than
    /// the speed, and beside a free viscous part that is friction which falls.
    fn sublinear(&self, best: Hypothesis) -> Hypothesis {
        let is = |a: &Atom, id: &str| a.term.kind.id() == id;
        let not_sublinear = |a: &Atom| is(a, "sublinear_viscous") && a.term.shape[1] > 1.0;
        let Some(i) = best.atoms.iter().position(not_sublinear) else { return best };
        if best.atoms.iter().any(|a| is(a, "stribeck")) {
            return best;
        }
        let mut others = best.atoms.clone();
        others.remove(i);
        let without = Hypothesis::new(self.stage, others);
        let rivals = self.catalogue.testable().into_iter().filter(|a| is(a, "stribeck")).filter_map(|a| {
            let mut atoms = best.atoms.clone();
            atoms[i] = a.clone();
            Hypothesis::new(self.stage, atoms)
        });
        let rival = rivals.min_by(|a, b| self.cost(a).total_cmp(&self.cost(b)));
        let Some(rival) = rival.map(|h| self.refine(h, ROUGH)).filter(|h| self.physical(h)) else {
            return best;
        };
        if self.is_as_good(&rival, &best, without.as_ref()) { rival } else { best }
    }

    /// Whether `rival`, with another term in the place of one of `best`, explains what it does; `without`: neither's.
    pub fn is_as_good(&self, rival: &Hypothesis, best: &Hypothesis, without: Option<&Hypothesis>) -> bool {
        let beyond_best = |h: &Hypothesis| h.fit.heldout_sum() - best.fit.heldout_sum();
        self.interval(rival, best)[0] <= 0.0
            || beyond_best(rival) < AS_GOOD * without.map_or(0.0, beyond_best)
    }

    /// The simplest hypothesis with one term in the place of the `group`, where one is as good.
    fn simpler(&self, best: &Hypothesis, group: &[usize]) -> Option<Hypothesis> {
        let size = |a: &Atom| a.columns.len() + a.term.kind.shape().len();
        let of_group: usize = group.iter().map(|i| size(&best.atoms[*i])).sum();
        let others: Vec<Atom> = best
            .atoms
            .iter()
            .enumerate()
            .filter(|(i, _)| !group.contains(i))
            .map(|(_, a)| a.clone())
            .collect();
        let basis = Basis::of(&Hypothesis::columns(self.stage, &others));
        let mut own = vec![0.0; self.stage.y.len()];
        for i in group {
            for (sum, x) in own.iter_mut().zip(self.contribution(best, *i, &basis)) {
                *sum += x;
            }
        }
        let kept = |a: &Atom| Basis::of(&a.outside(&basis)).captured(&own);
        let power = dot(&own, &own);
        // A grid point is not the best shape yet: let in a little less and refine.
        let mut simpler: Vec<(usize, f64, &Atom)> = self
            .catalogue
            .testable()
            .into_par_iter()
            .filter(|a| !best.has(a.term.kind) && size(a) < of_group)
            .map(|a| (size(a), kept(a), a))
            .filter(|(_, kept, _)| *kept >= 0.8 * power)
            .collect();
        simpler.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        let mut tried: Vec<TermKind> = Vec::new();
        for (_, _, atom) in simpler {
            if tried.contains(&atom.term.kind) {
                continue;
            }
            tried.push(atom.term.kind);
            let mut atoms = others.clone();
            atoms.insert(group[0], atom.clone());
            let Some(rival) = Hypothesis::new(self.stage, atoms).map(|h| self.refine(h, ROUGH)) else {
                continue;
            };
            let as_good = kept(&rival.atoms[group[0]]) >= COLLINEAR * COLLINEAR * power
                && self.interval(&rival, best)[0] <= 0.0
                && self.physical(&rival);
            if as_good {
                return Some(rival);
            }
        }
        None
    }

    /// What term `i` adds to the prediction, outside the span of `basis`.
    pub fn contribution(&self, h: &Hypothesis, i: usize, basis: &Basis) -> Vec<f64> {
        let mut sum = vec![0.0; self.stage.y.len()];
        for (c, column) in h.coefficients(self.stage, i).iter().zip(&h.atoms[i].columns) {
            for (s, x) in sum.iter_mut().zip(column) {
                *s += c * x;
            }
        }
        basis.project_out(&sum)
    }

    /// Whether every gain lies in the range its effect accepts, and a mass that the baseline has is not taken below zero
    /// by what would then push it.
    pub fn physical(&self, h: &Hypothesis) -> bool {
        let mass = h.fit.coefficients.first().copied().unwrap_or(0.0);
        (mass >= 0.0 || self.stage.blocks.mass < 0.0)
            && (0..h.atoms.len()).all(|i| h.atoms[i].physical(h.coefficients(self.stage, i)))
    }

    /// Residual of `parent` against every testable column, noise taken from `child`.
    pub fn test(&self, parent: &Hypothesis, child: &Hypothesis, extra: &[Atom]) -> (Vec<Term>, Family) {
        let basis = Basis::of(&Hypothesis::columns(self.stage, &parent.atoms));
        let spread =
            (dot(&child.fit.residual, &child.fit.residual) / child.fit.residual.len().max(1) as f64).sqrt();
        let score = |atom: &&Atom| -> Vec<(Term, Scores, Scores, f64)> {
            let of = |column: &Vec<f64>| {
                let rest = basis.project_out(column);
                let size = dot(&rest, &rest).sqrt();
                (size > 0.02 * dot(column, column).sqrt()).then(|| {
                    let blocks = &self.stage.blocks;
                    let observed = block_scores(&rest, &parent.fit.residual, blocks);
                    (atom.term, observed, block_scores(&rest, &child.fit.residual, blocks), size * spread)
                })
            };
            atom.columns.iter().filter_map(of).collect()
        };
        let atoms: Vec<&Atom> = self.catalogue.testable().into_iter().chain(extra).collect();
        let scores: Vec<_> = atoms.par_iter().flat_map_iter(score).collect();
        let (mut observed, mut noise, mut scale, mut terms) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (t, o, n, s) in scores {
            terms.push(t);
            observed.push(o);
            noise.push(n);
            scale.push(s);
        }
        (terms, family(&observed, &noise, &scale, FLIPS, self.seed))
    }

    /// Family-wise p of the best column of `atoms` against `parent`.
    pub fn significance(&self, parent: &Hypothesis, child: &Hypothesis, atoms: &[Atom]) -> f64 {
        let (terms, family) = self.test(parent, child, atoms);
        terms
            .iter()
            .zip(&family.p)
            .filter(|(t, _)| atoms.iter().any(|a| a.term == **t))
            .map(|(_, p)| *p)
            .fold(1.0, f64::min)
    }

    /// 95 % interval of the held-out gain from `parent` to `child`.
    pub fn interval(&self, parent: &Hypothesis, child: &Hypothesis) -> [f64; 2] {
        gain_interval(
            &parent.fit.heldout,
            &child.fit.heldout,
            &self.stage.block_weight(),
            &self.stage.blocks.recordings,
            1000,
            self.seed ^ 0x9e37,
        )
    }

    /// Held-out squares, and what the shapes cost: they were chosen on all the data, which holding out does not see.
    /// ln(n)/2 each in log-likelihood, as in Schwarz's criterion.
    fn cost(&self, h: &Hypothesis) -> f64 {
        let rows: f64 = self.stage.block_weight().iter().sum();
        let shapes: usize = h.atoms.iter().map(|a| a.term.kind.shape().len()).sum();
        h.fit.heldout_sum() + shapes as f64 * rows.max(2.0).ln() * self.floor / rows.max(1.0)
    }

    fn material(&self, parent: &Hypothesis, child: &Hypothesis, start: f64) -> bool {
        let gain = parent.fit.heldout_sum() - child.fit.heldout_sum();
        let above = |sum: f64| sum - self.floor;
        let worth = (MATERIAL * above(start)).min(MOST_OF_REST * above(parent.fit.heldout_sum()));
        let mut added = (0..child.atoms.len()).filter(|i| !parent.has(child.atoms[*i].term.kind));
        let nowhere = Basis::default();
        let share = |i| spread(&self.contribution(child, i, &nowhere), &self.stage.blocks);
        let least = added.clone().map(share).reduce(f64::min);
        let worth = worth.max(self.systematic * least.unwrap_or(1.0));
        let smooths = added.any(|i| child.atoms[i].term.kind.acts(Acts::Behind));
        gain > worth
            && (!smooths
                || crate::transport::saved(self, &parent.atoms, &child.atoms).is_some_and(|s| s > worth))
    }

    fn holds(&self, parent: &Hypothesis, child: &Hypothesis, start: f64) -> bool {
        let new: Vec<Atom> = child.atoms.iter().filter(|a| !parent.has(a.term.kind)).cloned().collect();
        child.fit.heldout_sum() < parent.fit.heldout_sum()
            && self.material(parent, child, start)
            && self.interval(parent, child)[0] > 0.0
            && (new.is_empty() || self.significance(parent, child, &new) <= LEVEL)
    }

    /// Drops terms that do not hold against the others, worst first; returns each survivor's p value.
    fn prune(&self, mut best: Hypothesis, start: f64) -> (Hypothesis, Vec<f64>) {
        loop {
            let mut p = Vec::new();
            let mut worst: Option<(f64, Hypothesis)> = None;
            for i in 0..best.atoms.len() {
                let mut atoms = best.atoms.clone();
                let removed = atoms.remove(i);
                let Some(without) = Hypothesis::new(self.stage, atoms) else {
                    p.push(1.0);
                    continue;
                };
                let value = self.significance(&without, &best, std::slice::from_ref(&removed));
                p.push(value);
                // without the others a gain may have left the range its effect accepts
                let stands = value <= LEVEL
                    && best.atoms[i].physical(best.coefficients(self.stage, i))
                    && self.interval(&without, &best)[0] > 0.0
                    && self.material(&without, &best, start);
                let gain = without.fit.heldout_sum() - best.fit.heldout_sum();
                if !stands && worst.as_ref().is_none_or(|(g, _)| gain < *g) {
                    worst = Some((gain, without));
                }
            }
            match worst {
                Some((_, without)) => best = crate::transport::settle(self, self.refine(without, FINE)),
                None => return (best, p),
            }
        }
    }

    /// Extensions of a hypothesis by one term and by two.
    fn extend(&self, from: &Hypothesis) -> Vec<Hypothesis> {
        let basis = Basis::of(&Hypothesis::columns(self.stage, &from.atoms));
        let residual = &from.fit.residual;
        // The best shape of each effect, with and without shared directions, among those whose gain it accepts: a delay
        // that is tried too short would need more than the whole force.
        let gains: Vec<(f64, &Atom)> = self
            .catalogue
            .testable()
            .into_par_iter()
            .filter(|atom| !from.has(atom.term.kind))
            .map(|atom| {
                let rest = atom.outside(&basis);
                let alone = match &rest[..] {
                    [only] => atom.physical(&[dot(only, residual) / dot(only, only)]),
                    _ => true,
                };
                (if alone { Basis::of(&rest).captured(residual) } else { 0.0 }, atom)
            })
            .collect();
        let mut ranked: Vec<(f64, &Atom)> = Vec::new();
        for entry in gains {
            let term = entry.1.term;
            let same = |other: &Atom| other.term.kind == term.kind && other.term.variant == term.variant;
            match ranked.iter_mut().find(|(_, a)| same(a)) {
                Some(best) if best.0 < entry.0 => *best = entry,
                Some(_) => {}
                None => ranked.push(entry),
            }
        }
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut trials: Vec<Vec<Atom>> = ranked.iter().take(14).map(|(_, a)| vec![(*a).clone()]).collect();
        if from.atoms.len() + 2 <= self.max_terms {
            let each: Vec<_> = ranked.par_iter().map(|(alone, a)| (*alone, *a, a.outside(&basis))).collect();
            let with = |(i, (alone_a, a, rest_a)): (usize, &(f64, &Atom, Vec<Vec<f64>>))| {
                let mut pairs = Vec::new();
                for (alone_b, b, rest_b) in each.iter().skip(i + 1).take(24) {
                    if a.term.kind == b.term.kind {
                        continue;
                    }
                    let both: Vec<&[f64]> = rest_a.iter().chain(rest_b).map(Vec::as_slice).collect();
                    let gain = Basis::of(&both).captured(residual);
                    if gain > 1.05 * alone_a.max(*alone_b) {
                        pairs.push((gain, vec![(*a).clone(), (*b).clone()]));
                    }
                }
                pairs
            };
            let mut pairs: Vec<_> = each.par_iter().take(24).enumerate().flat_map_iter(with).collect();
            pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
            trials.extend(pairs.into_iter().take(8).map(|(_, p)| p));
        }
        trials
            .into_par_iter()
            .filter_map(|new| {
                let atoms = from.atoms.iter().cloned().chain(new).collect();
                Hypothesis::new(self.stage, atoms)
            })
            .filter(|h| self.physical(h))
            .collect()
    }
}

/// Participation of `x`: 1 where all are of one size, 1/n where only one is not zero.
fn participation(x: impl Iterator<Item = f64>) -> f64 {
    let (count, sum, square) = x.fold((0.0, 0.0, 0.0), |(n, s, q), x| (n + 1.0, s + x, q + x * x));
    if square > 0.0 { sum * sum / (count * square) } else { 1.0 }
}

/// Share of each block's rows on which a force acts: 1 for anything as broad as normal noise, whose fourth moment is 3,
/// small for what acts in every block but around reversals only. What acts in a few blocks and there everywhere has 1.
fn spread(force: &[f64], blocks: &crate::linear::Blocks) -> f64 {
    let rows = participation(force.iter().map(|x| x * x));
    let energy = |k: usize| blocks.rows(k).map(|r| force[r] * force[r]).sum::<f64>();
    (3.0 * rows / participation((0..blocks.len()).map(energy))).min(1.0)
}

fn kinds_of(h: &Hypothesis) -> Vec<&'static str> {
    let mut kinds: Vec<&str> = h.atoms.iter().map(|a| a.term.kind.id()).collect();
    kinds.sort_unstable();
    kinds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::Blocks;

    #[test]
    fn what_lasts_milliseconds_after_a_reversal_was_too_little_on_the_average_of_all_samples() {
        let rows = 1000;
        let blocks = Blocks { edges: (0..=10).map(|k| 100 * k).collect(), ..Blocks::default() };
        let force = |of: &dyn Fn(usize) -> f64| spread(&(0..rows).map(of).collect::<Vec<_>>(), &blocks);
        assert_eq!(force(&|i| (0.05 * i as f64).sin()), 1.0);
        // two rows of every fifty
        let pulses = force(&|i| f64::from(u8::from(i % 50 < 2)));
        assert!((pulses - 3.0 * 0.04).abs() < 1e-9, "{pulses}");
        // one block only, and there everywhere: a share of all rows as small, and no less to be asked of it
        assert_eq!(force(&|i| f64::from(u8::from(i < 100))), 1.0);
        assert_eq!(force(&|_| 0.0), 1.0);
    }
}
