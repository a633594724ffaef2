//! The force that acts on the body, as far as it is known: what stands for "the applied force" inside a regressor, because
//! the measured force's own noise there would correlate with itself.
//!
//! At first that is the baseline. What moves, distorts or follows the force is then found with a force from which it
//! still bends the mass and the friction, so that its size is wrong by the square of what it does; once the rest is
//! known the force is taken from all of it.

use crate::search::Hypothesis;
use crate::term::{Stage, TermKind};
use friction::effects::{EffectKind, MAX_GAINS, MAX_SHAPE};

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
