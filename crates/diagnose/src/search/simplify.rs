//! The simplest hypothesis that explains a recording as well.

use crate::library::term::{Term, TermKind};
use crate::search::catalogue::is_testable;
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::judgement::{COLLINEAR, Search};
use crate::search::overlap::Overlap;
use crate::search::refine::ROUGH;
use nalgebra::DVector;
use signals::Basis;

impl Search<'_> {
    /// Takes out of each term the gains that its recording does not ask for: the second harmonic, a second end of the
    /// stroke, a difference between the directions. A line may stand at twice its wavelength as a second harmonic.
    pub fn plain(&self, mut best: Hypothesis) -> Hypothesis {
        for i in 0..best.atoms.len() {
            let own = best.atoms[i].clone();
            let kind = own.term.kind;
            let mut shapes = vec![own.term.shape];
            if let Some(wave) = kind.about().wavelength() {
                let mut half = own.term.shape;
                half[wave] *= 0.5;
                shapes.push(half);
            }
            let mut simpler: Vec<Hypothesis> = (0..kind.variants().len())
                .flat_map(|variant| shapes.iter().map(move |shape| Term { kind, shape: *shape, variant }))
                .filter_map(|term| {
                    let mut atom = Atom::new(self.design, &self.catalogue.baseline, term);
                    atom.reliable = own.reliable;
                    let fewer = is_testable(&atom) && atom.columns.len() < own.columns.len();
                    let mut atoms = best.atoms.clone();
                    atoms[i] = atom;
                    fewer.then(|| Hypothesis::new(self.design, atoms)).flatten()
                })
                .map(|h| {
                    let needed = self.needed(&h, &best);
                    self.refine_by(h, ROUGH, needed)
                })
                .filter(|h| self.physical(h) && !self.gains_surely(&h.fit, &best.fit))
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
    pub fn simplify(&self, mut best: Hypothesis) -> Hypothesis {
        let count = best.atoms.len();
        let mut overlap = self.overlap(&best);
        for i in 0..count {
            if let Some(rival) = self.simpler(&best, &overlap, &[i]) {
                best = rival;
                overlap = self.overlap(&best);
            }
        }
        for pair in (0..count).flat_map(|i| (i + 1..count).map(move |j| [i, j])) {
            if let Some(rival) = self.simpler(&best, &overlap, &pair) {
                return self.simplify(rival);
            }
        }
        best
    }

    /// Replaces a term by the effect that its shape amounts to, where that one fits as well: lost motion with hardly any gap is
    /// presliding.
    pub fn rather(&self, best: Hypothesis) -> Hypothesis {
        let rather = |a: &Atom| match a.term.kind {
            TermKind::Force(kind) => kind.rather(&a.term.shape).map(TermKind::Force),
            TermKind::Series(_) => None,
        };
        let Some((i, kind)) = best.atoms.iter().enumerate().find_map(|(i, a)| Some((i, rather(a)?))) else {
            return best;
        };
        let mut others = best.atoms.clone();
        others.remove(i);
        let without = Hypothesis::new(self.design, others);
        if best.has(kind) {
            // two of a kind: the other one takes its part
            return without.map_or(best, |h| self.rather(self.refine(h, ROUGH)));
        }
        let rivals = self.catalogue.testable().into_iter().filter(|a| a.term.kind == kind).filter_map(|a| {
            let mut atoms = best.atoms.clone();
            atoms[i] = a.clone();
            Hypothesis::new(self.design, atoms)
        });
        let rival = rivals.min_by(|a, b| self.cost(a).total_cmp(&self.cost(b)));
        let Some(rival) = rival.map(|h| self.refine(h, ROUGH)).filter(|h| self.physical(h)) else {
            return best;
        };
        if self.is_as_good(&rival, &best, without.as_ref()) { rival } else { best }
    }

    /// The catalogue's atoms that may stand in the place of one or two terms of `best`, with its columns.
    fn overlap(&self, best: &Hypothesis) -> Overlap<'_> {
        let mut sizes: Vec<usize> = best.atoms.iter().map(Atom::parameters).collect();
        sizes.sort_unstable();
        let most: usize = sizes.iter().rev().take(2).sum();
        let atoms = self.catalogue.testable().into_iter();
        let atoms = atoms.filter(|a| !best.has(a.term.kind) && a.parameters() < most).collect();
        Overlap::new(atoms, &Hypothesis::columns(self.design, &best.atoms))
    }

    /// Squared error that `rival` has to lose before it may be as good as `best`.
    fn needed(&self, rival: &Hypothesis, best: &Hypothesis) -> f64 {
        let rows = self.design.effective_rows();
        let worse = self.interval(rival, best)[0].max(0.0);
        let rms = self.design.rms(rival.fit.heldout_sum());
        rows * worse * (2.0 * rms - worse)
    }

    /// The simplest hypothesis with one term in the place of the `group`, where one is as good.
    fn simpler(&self, best: &Hypothesis, overlap: &Overlap, group: &[usize]) -> Option<Hypothesis> {
        let of_group: usize = group.iter().map(|i| best.atoms[*i].parameters()).sum();
        let others: Vec<Atom> = best
            .atoms
            .iter()
            .enumerate()
            .filter(|(i, _)| !group.contains(i))
            .map(|(_, a)| a.clone())
            .collect();
        let in_group = |c: usize| {
            group.iter().any(|i| {
                let from = best.offset(self.design, *i);
                (from..from + best.atoms[*i].columns.len()).contains(&c)
            })
        };
        let coefficients = best.fit.coefficients.iter().enumerate();
        let share = DVector::from_iterator(
            best.fit.coefficients.len(),
            coefficients.map(|(c, x)| if in_group(c) { *x } else { 0.0 }),
        );
        let others_at = (0..share.len()).filter(|c| !in_group(*c)).collect();
        let span = overlap.span(others_at, share)?;
        // A grid point is not the best shape yet: let in a little less and refine.
        let mut simpler: Vec<(usize, f64, &Atom)> = overlap
            .atoms
            .iter()
            .enumerate()
            .filter(|(_, a)| a.parameters() < of_group)
            .map(|(i, a)| (a.parameters(), overlap.captured(&span, i), *a))
            .filter(|(_, kept, _)| *kept >= 0.8 * span.power)
            .collect();
        simpler.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        if simpler.is_empty() {
            return None;
        }
        let basis = Basis::of(&Hypothesis::columns(self.design, &others));
        let mut own = vec![0.0; self.design.y.len()];
        for i in group {
            for (sum, x) in own.iter_mut().zip(self.contribution(best, *i, &basis)) {
                *sum += x;
            }
        }
        let mut tried: Vec<TermKind> = Vec::new();
        for (_, _, atom) in simpler {
            if tried.contains(&atom.term.kind) {
                continue;
            }
            tried.push(atom.term.kind);
            let mut atoms = others.clone();
            atoms.insert(group[0], atom.clone());
            let Some(rival) = Hypothesis::new(self.design, atoms) else { continue };
            let needed = self.needed(&rival, best);
            let rival = self.refine_by(rival, ROUGH, needed);
            let kept = Basis::of(&rival.atoms[group[0]].outside(&basis)).captured(&own);
            let as_good = kept >= COLLINEAR * COLLINEAR * span.power
                && !self.gains_surely(&rival.fit, &best.fit)
                && self.physical(&rival);
            if as_good {
                return Some(rival);
            }
        }
        None
    }
}
