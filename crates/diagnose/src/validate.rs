//! Recordings that were not fitted: structure and parameters frozen, and beside it the figure with declared nuisances
//! fitted again.

use crate::acting::Acting;
use crate::engine::BASELINE;
use crate::intake::Intake;
use crate::linear::{Blocks, dot, fit};
use crate::nuisance::{Nuisance, PerRecording, SURE, nearest};
use crate::result::Validation;
use crate::search::Hypothesis;
use crate::term::Stage;
use crate::track::Channels;

/// What is frozen.
pub(crate) struct Frozen<'a> {
    /// The stage it was fitted on.
    pub stage: &'a Stage,
    pub cutoff: f64,
    /// The force that acted.
    pub acting: &'a Acting,
    pub baseline: &'a Hypothesis,
    pub found: &'a Hypothesis,
    /// Nuisances that may differ there.
    pub declared: &'a [Nuisance],
}

/// A nuisance with its estimate and standard deviation.
type Fitted = (Nuisance, f64, f64);

impl Frozen<'_> {
    /// Judges each recording by itself.
    pub fn judge(&self, judged: &Intake) -> Vec<Validation> {
        let of = |(index, name): (usize, &String)| {
            let stretches: Vec<Channels> =
                judged.stretches.iter().filter(|s| s.recording == index).cloned().collect();
            let mut stage = Stage::new(&stretches, self.cutoff, self.stage.delay)?;
            if stage.baseline.len() < BASELINE.len() {
                return None;
            }
            stage.model_force(self.acting);
            Some(self.one(&stage, index, name, judged.rotary))
        };
        judged.names.iter().enumerate().filter_map(of).collect()
    }

    fn one(&self, stage: &Stage, index: usize, name: &str, rotary: bool) -> Validation {
        let rows: f64 = stage.block_weight().iter().sum();
        let size = dot(&stage.y, &stage.y).max(1e-300);
        let square = |rest: &[f64]| dot(rest, rest);
        let before = square(&self.rest(stage, self.baseline));
        let after = square(&self.rest(stage, self.found));
        let again = (!self.declared.is_empty()).then(|| {
            let (before, _) = self.refit(stage, index, self.baseline);
            let (after, fitted) = self.refit(stage, index, self.found);
            (before, after, fitted)
        });
        let fitted: &[Fitted] = again.as_ref().map_or(&[], |a| &a.2);
        Validation {
            recording: name.to_string(),
            rms_before: (before / rows).sqrt(),
            rms_after: (after / rows).sqrt(),
            relative_before: (before / size).sqrt(),
            relative_after: (after / size).sqrt(),
            refitted: fitted.iter().map(|(n, ..)| n.id().to_string()).collect(),
            rms_before_refitted: again.as_ref().map(|a| (a.0 / rows).sqrt()),
            rms_after_refitted: again.as_ref().map(|a| (a.1 / rows).sqrt()),
            relative_before_refitted: again.as_ref().map(|a| (a.0 / size).sqrt()),
            relative_after_refitted: again.as_ref().map(|a| (a.1 / size).sqrt()),
            nuisances: fitted
                .iter()
                .map(|&(nuisance, value, std)| PerRecording {
                    recording: name.to_string(),
                    nuisance: nuisance.id().into(),
                    value,
                    std,
                    unit: nuisance.unit(rotary).into(),
                })
                .collect(),
        }
    }

    /// What a frozen hypothesis leaves.
    fn rest(&self, stage: &Stage, hypothesis: &Hypothesis) -> Vec<f64> {
        let mut rest = stage.y.clone();
        let mut take = |column: &[f64], c: f64| {
            for (r, x) in rest.iter_mut().zip(column) {
                *r -= c * x;
            }
        };
        // nuisances of the recordings that were fitted come behind what this stage has
        for (column, c) in stage.baseline.iter().zip(&hypothesis.fit.coefficients) {
            take(column, *c);
        }
        for (i, atom) in hypothesis.atoms.iter().enumerate() {
            let columns = stage.columns(&atom.term);
            for (a, c) in atom.active.iter().zip(hypothesis.coefficients(self.stage, i)) {
                if let Some(column) = columns.get(*a) {
                    take(column, *c);
                }
            }
        }
        rest
    }

    /// Least squared error over the declared nuisances, and where it is reached.
    fn refit(&self, stage: &Stage, index: usize, hypothesis: &Hypothesis) -> (f64, Vec<Fitted>) {
        let linear: Vec<(Nuisance, Vec<f64>)> = self
            .declared
            .iter()
            .filter_map(|&n| stage.nuisance_column(n, None).map(|column| (n, column)))
            .collect();
        let columns: Vec<&[f64]> = linear.iter().map(|(_, c)| c.as_slice()).collect();
        // none of these columns is an acceleration with noise of its own
        let blocks = Blocks { noise: Vec::new(), ..stage.blocks.clone() };
        let with = |stage: &Stage| -> (f64, Vec<Fitted>) {
            let rest = self.rest(stage, hypothesis);
            match fit(&columns, &rest, &blocks, 4) {
                Some(f) => {
                    let values = f.coefficients.iter().zip(&f.deviations);
                    let fitted = linear.iter().zip(values).map(|((n, _), (v, s))| (*n, *v, *s)).collect();
                    (dot(&f.residual, &f.residual), fitted)
                }
                None => (dot(&rest, &rest), Vec::new()),
            }
        };
        let still = with(stage);
        if !self.declared.contains(&Nuisance::Origin) {
            return still;
        }
        let (low, high) = stage
            .tracks
            .iter()
            .flat_map(|t| &t.x)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let span = high - low;
        let error = |shift: f64| with(&stage.shifted(index, shift)).0;
        // what was found may not depend on position at all
        if (error(0.01 * span) - still.0).abs() <= 1e-9 * still.0 {
            return still;
        }
        let rows: f64 = stage.block_weight().iter().sum();
        let (best, least) = nearest(0.5 * span, span, |least| SURE * least / rows.max(1.0), error);
        let h = 0.0025 * span;
        let bend = (error(best + h) + error(best - h) - 2.0 * least) / (h * h);
        let std = if bend > 0.0 { (2.0 * least / rows.max(1.0) / bend).sqrt() } else { f64::NAN };
        let (least, mut fitted) = with(&stage.shifted(index, best));
        fitted.push((Nuisance::Origin, best, std));
        (least, fitted)
    }
}
