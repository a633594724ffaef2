//! The force that acts on the body, as far as it is known: what stands for "the applied force" inside a regressor, because
//! the measured force's own noise there would correlate with itself.
//!
//! At first that is the baseline. What moves, distorts or follows the force is then found with a force from which it
//! still bends the mass and the friction, so that its size is wrong by the square of what it does; once the rest is
//! known the force is taken from all of it.

use crate::search::{Atom, Hypothesis, ROUGH, Search};
use crate::sensor::Acts;
use crate::term::{Stage, TermKind};
use crate::transport;
use friction::effects::{EffectKind, MAX_GAINS, MAX_SHAPE};

/// Rounds in which the force that acts settles: each leaves a tenth of the error of the one before.
const SETTLED: usize = 4;

/// Change of the force that acts, as a share of it, below which what was found with the old one stands.
const SAME_FORCE: f64 = 0.003;

/// Coefficients of the baseline, and the forces beyond it.
#[derive(Debug, Clone, Default)]
pub struct Acting {
    /// Baseline.
    pub baseline: Vec<f64>,
    /// Effects with gains and shape.
    pub effects: Vec<(EffectKind, [f64; MAX_GAINS], [f64; MAX_SHAPE])>,
}

impl Acting {
    /// The baseline alone.
    pub fn baseline(coefficients: &[f64]) -> Self {
        Self { baseline: coefficients.to_vec(), effects: Vec::new() }
    }

    /// What `found` says acts on the body: not what its channel shows beside.
    pub fn of(stage: &Stage, found: &Hypothesis) -> Self {
        let mut out = Self::baseline(&found.fit.coefficients);
        for (i, atom) in found.atoms.iter().enumerate() {
            if let TermKind::Force(kind) = atom.term.kind
                && !atom.term.kind.needs_force()
            {
                out.effects.push((kind, atom.gains(found.coefficients(stage, i)), atom.term.shape));
            }
        }
        out
    }
}

impl Stage {
    /// Sets the force that stands for the applied force inside regressors.
    pub fn model_force(&mut self, acting: &Acting) {
        if acting.baseline.len() < crate::engine::BASELINE.len() {
            return;
        }
        let mut forces: Vec<Vec<f64>> = self
            .tracks
            .iter()
            .map(|track| {
                let series = track.baseline();
                let at = |i: usize| series.iter().zip(&acting.baseline).map(|(s, c)| c * s[i]).sum();
                (0..track.len()).map(at).collect()
            })
            .collect();
        for (kind, gains, shape) in &acting.effects {
            for (force, units) in forces.iter_mut().zip(self.units::<MAX_GAINS>(*kind, shape)) {
                for (f, unit) in force.iter_mut().zip(units) {
                    *f += unit.iter().zip(gains).map(|(u, g)| u * g).sum::<f64>();
                }
            }
        }
        for (track, force) in self.tracks.iter_mut().zip(forces) {
            track.force_model = force;
        }
    }
}

/// The stage with the force that acts, where something was found that distorts or follows it: the baseline alone, which
/// stood for it, had taken up part of what was found.
pub fn settle(search: &Search, found: &Hypothesis) -> Option<(Stage, Acting)> {
    if !found.atoms.iter().any(|a| a.term.kind.needs_force()) {
        return None;
    }
    let (mut stage, mut noisy, mut found) = (search.stage.clone(), search.noisy.clone(), found.clone());
    let mut acting = Acting::of(&stage, &found);
    for _ in 0..SETTLED {
        stage.model_force(&acting);
        noisy.model_force(&acting);
        let search = Search { stage: &stage, noisy: &noisy, ..*search };
        let again =
            |a: &Atom| Atom { reliable: a.reliable, ..Atom::new(&stage, &search.catalogue.baseline, a.term) };
        let next = Hypothesis::new(&stage, found.atoms.iter().map(again).collect())?;
        // with a share that is free a time runs along the ridge on which their product is the same
        let moves = next.atoms.iter().any(|a| a.term.kind.acts(Acts::InTime));
        found = if moves { transport::nearby(&search, next) } else { search.refine(next, ROUGH) };
        // What the gain of a channel takes, the rest gives: alone, each answer misses by as much of the last error
        // as the gain is, to the other side. Halfway there is little left.
        let next = Acting::of(&stage, &found);
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
    stage.model_force(&acting);
    let moved = |of: fn(f64, f64) -> f64| -> f64 {
        let pairs = stage.tracks.iter().zip(&search.stage.tracks).flat_map(|(new, old)| {
            new.force_model.iter().zip(&old.force_model).zip(&new.mask).map(|((n, o), m)| (m * n, m * o))
        });
        pairs.map(|(new, old)| of(new, old).powi(2)).sum()
    };
    let settled = moved(|new, old| new - old) < SAME_FORCE * SAME_FORCE * moved(|new, _| new);
    (!settled).then_some((stage, acting))
}
