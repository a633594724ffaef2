//! Naming: a beam search over the catalogue with pair steps, each step tested against the best of a null
//! catalogue and against a bootstrap of its held-out gain, then pruned backward.

use crate::options::{Interrupted, Watch, tell};
use crate::regression::linear::Blocks;
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::judgement::{LEVEL, Search};
use crate::search::overlap::Overlap;
use crate::search::refine::{FINE, ROUGH};
use crate::search::significance::Claim;
use crate::search::transport;
use friction::effects::Acts;
use nalgebra::DVector;
use rayon::prelude::*;
use signals::Basis;

/// Smallest share of the mismatch above the floor for which a term is worth naming.
const MATERIAL: f64 = 0.01;
/// Or of what the terms before it left: where a spring is nearly all of the force, what stiffens it is less than a
/// hundredth of the mismatch and nearly all of the rest.
const MOST_OF_REST: f64 = 0.5;

impl Search<'_> {
    /// The best hypothesis whose every term is significant, holds out of sample and is material; with everything that `from`
    /// has already, unless it does not hold beside the rest.
    pub fn run(
        &self,
        from: Hypothesis,
        watch: Watch<'_>,
    ) -> Result<Option<(Hypothesis, Vec<f64>)>, Interrupted> {
        let Some(empty) = Hypothesis::new(self.design, Vec::new()) else { return Ok(None) };
        let start = empty.fit.heldout_sum();
        let mut best = from.clone();
        let mut beam = vec![from];
        while best.atoms.len() < self.max_terms {
            let share = 0.3 + 0.5 * best.atoms.len() as f32 / self.max_terms as f32;
            let what = format!("naming: {} found", best.atoms.len());
            tell(watch, share, &what)?;
            let mut next: Vec<Hypothesis> = beam.iter().flat_map(|h| self.extend(h)).collect();
            tell(watch, share, &what)?;
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
        tell(watch, 0.3 + 0.5 * best.atoms.len() as f32 / self.max_terms as f32, "refining")?;
        let best = self.refine(self.rather(self.plain(self.simplify(best))), FINE);
        Ok(Some(self.prune(transport::settle(self, best), start)))
    }

    /// Indices of the atoms of `child` that `parent` lacks.
    fn added(&self, parent: &Hypothesis, child: &Hypothesis) -> Vec<usize> {
        (0..child.atoms.len()).filter(|i| !self.has(&parent.atoms, &child.atoms[*i].term)).collect()
    }

    fn material(&self, parent: &Hypothesis, child: &Hypothesis, start: f64) -> bool {
        let gain = parent.fit.heldout_sum() - child.fit.heldout_sum();
        let above = |sum: f64| sum - self.floor;
        let worth = (MATERIAL * above(start)).min(MOST_OF_REST * above(parent.fit.heldout_sum()));
        let added = self.added(parent, child);
        let nowhere = Basis::default();
        let share = |i: &usize| spread(&self.contribution(child, *i, &nowhere), &self.design.blocks);
        let least = added.iter().map(share).reduce(f64::min);
        let worth = worth.max(self.systematic * least.unwrap_or(1.0));
        let smooths = added.iter().any(|i| child.atoms[*i].term.kind.acts(Acts::Behind));
        gain > worth
            && (!smooths || transport::saved(self, &parent.atoms, &child.atoms).is_some_and(|s| s > worth))
    }

    fn holds(&self, parent: &Hypothesis, child: &Hypothesis, start: f64) -> bool {
        let new: Vec<Atom> = self.added(parent, child).iter().map(|i| child.atoms[*i].clone()).collect();
        child.fit.heldout_sum() < parent.fit.heldout_sum()
            && self.material(parent, child, start)
            && self.gains_surely(&parent.fit, &child.fit)
            && (new.is_empty() || self.significance(parent, child, &new) <= LEVEL)
    }

    /// Drops terms that do not hold against the others, worst first; returns each survivor's p value. A term with an
    /// unphysical gain is dropped first, so that no other term is judged beside it.
    pub fn prune(&self, mut best: Hypothesis, start: f64) -> (Hypothesis, Vec<f64>) {
        loop {
            let without = |i: usize| {
                let mut atoms = best.atoms.clone();
                atoms.remove(i);
                Hypothesis::new(self.design, atoms)
            };
            let fewer: Vec<Option<Hypothesis>> = (0..best.atoms.len()).into_par_iter().map(without).collect();
            let claims: Vec<(usize, &Hypothesis)> =
                fewer.iter().enumerate().filter_map(|(i, h)| Some((i, h.as_ref()?))).collect();
            let tested: Vec<Claim> = claims
                .iter()
                .map(|(i, without)| Claim { without, atoms: std::slice::from_ref(&best.atoms[*i]) })
                .collect();
            let mut p = vec![1.0; best.atoms.len()];
            let mut worst: Option<((bool, f64), usize)> = None;
            for ((i, without), value) in claims.iter().zip(self.significances(&best, &tested)) {
                let i = *i;
                p[i] = value;
                // without the others a gain may have left the range its effect accepts
                let physical = best.atoms[i].physical(best.coefficients(self.design, i));
                let stands = value <= LEVEL
                    && physical
                    && self.gains_surely(&without.fit, &best.fit)
                    && self.material(without, &best, start);
                let gain = without.fit.heldout_sum() - best.fit.heldout_sum();
                if !stands && worst.is_none_or(|(least, _)| (physical, gain) < least) {
                    worst = Some(((physical, gain), i));
                }
            }
            let without = worst.and_then(|(_, i)| fewer.into_iter().nth(i).flatten());
            match without {
                Some(without) => best = transport::settle(self, self.refine(without, FINE)),
                None => return (best, p),
            }
        }
    }

    /// Extensions of a hypothesis by one term and by two.
    fn extend(&self, from: &Hypothesis) -> Vec<Hypothesis> {
        let residual = &from.fit.residual;
        // The best shape of each effect, with and without shared directions, among those whose gain it accepts: a delay
        // that is tried too short would need more than the whole force.
        let testable =
            self.catalogue.testable().into_iter().filter(|atom| !self.has(&from.atoms, &atom.term)).collect();
        let columns = Hypothesis::columns(self.design, &from.atoms);
        let last = columns.len();
        let overlap = Overlap::new(testable, &[&columns[..], &[residual.as_slice()]].concat());
        let y = DVector::from_fn(last + 1, |i, _| if i == last { 1.0 } else { 0.0 });
        let Some(span) = overlap.span((0..last).collect(), y) else { return Vec::new() };
        let gains = (0..overlap.atoms.len()).into_par_iter().map(|i| {
            let outside = overlap.outside(&span, i);
            let accepted = outside.gain().is_none_or(|gain| overlap.atoms[i].physical(&[gain]));
            (if accepted { outside.captured() } else { 0.0 }, i)
        });
        let gains: Vec<(f64, usize)> = gains.collect();
        let mut ranked: Vec<(f64, usize)> = Vec::new();
        for entry in gains {
            let term = overlap.atoms[entry.1].term;
            let same = |other: &Atom| other.term.kind == term.kind && other.term.variant == term.variant;
            match ranked.iter_mut().find(|(_, i)| same(overlap.atoms[*i])) {
                Some(best) if best.0 < entry.0 => *best = entry,
                Some(_) => {}
                None => ranked.push(entry),
            }
        }
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let atom = |i: usize| overlap.atoms[i].clone();
        let mut trials: Vec<Vec<Atom>> = ranked.iter().take(14).map(|(_, i)| vec![atom(*i)]).collect();
        if from.atoms.len() + 2 <= self.max_terms {
            let places: Vec<usize> = ranked.iter().map(|(_, i)| *i).take(48).collect();
            let both = overlap.pairs(&span, &places);
            let with = |i: usize| {
                let (both, ranked, overlap) = (&both, &ranked, &overlap);
                let later = (i + 1..ranked.len()).take(24);
                later.filter_map(move |j| {
                    let ((alone_a, a), (alone_b, b)) = (ranked[i], ranked[j]);
                    let (a, b) = (overlap.atoms[a], overlap.atoms[b]);
                    if a.term.kind == b.term.kind {
                        return None;
                    }
                    let gain = both.captured(i, j);
                    (gain > 1.05 * alone_a.max(alone_b)).then(|| (gain, vec![a.clone(), b.clone()]))
                })
            };
            let mut pairs: Vec<_> = (0..ranked.len().min(24)).into_par_iter().flat_map_iter(with).collect();
            pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
            trials.extend(pairs.into_iter().take(8).map(|(_, p)| p));
        }
        trials
            .into_par_iter()
            .filter_map(|new| {
                let atoms: Vec<Atom> = from.atoms.iter().cloned().chain(new).collect();
                let parameters: usize = atoms.iter().map(Atom::parameters).sum();
                (parameters <= self.max_parameters).then(|| Hypothesis::new(self.design, atoms))?
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
fn spread(force: &[f64], blocks: &Blocks) -> f64 {
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
