//! The applied force, modelled again when effects are known.

use crate::library::applied_force::AppliedForce;
use crate::library::design_matrix::DesignMatrix;
use crate::library::term::TermKind;
use crate::search::hypothesis::Hypothesis;
use crate::search::judgement::Search;
use crate::search::refine::ROUGH;
use crate::search::transport;

/// Rounds in which the force that acts settles: each leaves a tenth of the error of the one before.
const SETTLED: usize = 4;

/// Change of the force that acts, as a share of it, below which what was found with the old one stands.
const SAME_FORCE: f64 = 0.003;

/// Rounds in which a force follows that reads itself.
const FOLLOWED: usize = 60;
/// Change of a round, as a share of the force, after which it does.
const FOLLOWS: f64 = 1e-4;

/// What `found` says acts on the body: not what its channel shows beside.
pub fn applied_force(design: &DesignMatrix, found: &Hypothesis) -> AppliedForce {
    let mut out = AppliedForce::baseline(design.physics(&found.fit.coefficients));
    for (i, atom) in found.atoms.iter().enumerate() {
        if let TermKind::Force(kind) = atom.term.kind
            && !atom.term.kind.needs_force()
        {
            out.effects.push((kind, atom.gains(found.coefficients(design, i)), atom.term.shape));
        }
    }
    out
}

/// The design matrix with the force that acts, where something was found that distorts or follows it: the baseline alone, which
/// stood for it, had taken up part of what was found.
pub fn settle(search: &Search, found: &Hypothesis) -> Option<(DesignMatrix, AppliedForce)> {
    if !found.atoms.iter().any(|a| a.term.kind.needs_force()) {
        return None;
    }
    let (mut design, mut noisy, mut found) = (search.design.clone(), search.noisy.clone(), found.clone());
    let mut acting = applied_force(&design, &found);
    for _ in 0..SETTLED {
        design.model_force(&acting);
        noisy.model_force(&acting);
        let search = Search { design: &design, noisy: &noisy, ..*search };
        let again = found.atoms.iter().map(|a| a.again(&design, &search.catalogue.baseline));
        let next = Hypothesis::new(&design, again.collect())?;
        // with a share that is free a time runs along the ridge on which their product is the same
        let moves = next.atoms.iter().any(|a| a.term.kind.moves_in_time());
        found = if moves { transport::nearby(&search, next) } else { search.refine(next, ROUGH) };
        // What the gain of a channel takes, the rest gives: alone, each answer misses by as much of the last error
        // as the gain is, to the other side. Halfway there is little left.
        let next = applied_force(&design, &found);
        for (old, new) in acting.baseline.iter_mut().zip(&next.baseline) {
            *old = 0.5 * (*old + new);
        }
        for ((_, gains, shape), (_, new, at)) in acting.effects.iter_mut().zip(next.effects) {
            for (old, new) in gains.iter_mut().zip(new) {
                *old = 0.5 * (*old + new);
            }
            *shape = at;
        }
    }
    design.model_force(&acting);
    (moved(&design, &force(search.design)) >= SAME_FORCE).then_some((design, acting))
}

/// The force that acts, at every sample of every track.
fn force(design: &DesignMatrix) -> Vec<Vec<f64>> {
    design.tracks.iter().map(|t| t.force_model.clone()).collect()
}

/// Change of the force that acts, as a share of it, where the body slides.
fn moved(new: &DesignMatrix, old: &[Vec<f64>]) -> f64 {
    let sum = |of: fn(f64, f64) -> f64| -> f64 {
        let pairs = new.tracks.iter().zip(old).flat_map(|(new, old)| {
            new.force_model.iter().zip(old).zip(&new.mask).map(|((n, o), m)| (m * n, m * o))
        });
        pairs.map(|(new, old)| of(new, old).powi(2)).sum()
    };
    (sum(|new, old| new - old) / sum(|new, _| new).max(1e-300)).sqrt()
}

/// Root mean square error of the force that the terms of `found` read, and of the one that follows from `found` alone.
pub fn read_and_followed(search: &Search, found: &Hypothesis) -> (f64, f64) {
    let acting = applied_force(search.design, found);
    let mut design = search.design.clone();
    for _ in 0..FOLLOWED {
        let before = force(&design);
        design.model_force(&acting);
        if moved(&design, &before) < FOLLOWS {
            break;
        }
    }
    let error = |of: &DesignMatrix| {
        let force = of.rows(|t| t.pass(&t.force_model));
        of.rms(force.iter().zip(&of.y).map(|(f, y)| (f - y).powi(2)).sum())
    };
    (error(search.design), error(&design))
}
