//! Recordings that were not fitted: the error with structure and parameters frozen, and the error with the declared
//! nuisances fitted again.

use crate::findings::nuisance::{MIN_CHI_SQUARE, nearest};
use crate::library::applied_force::AppliedForce;
use crate::library::design_matrix::DesignMatrix;
use crate::per_recording::{Nuisance, PerRecording};
use crate::preparation::intake::Intake;
use crate::regression::linear::{Blocks, fit};
use crate::result::Validation;
use crate::search::hypothesis::Hypothesis;
use crate::search::regression::Regression;
use friction::Geometry;
use signals::{Channels, dot};

/// A recording that was not fitted.
pub(crate) struct Judge {
    index: usize,
    name: String,
    design: DesignMatrix,
}

impl Judge {
    /// Name of the recording.
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// The recordings of `judged`, each by itself, with the further columns that the error of what was `fitted` follows;
/// `acting` is the force that acts.
pub(crate) fn judges(judged: &Intake, cutoff: f64, fitted: &Regression, acting: &AppliedForce) -> Vec<Judge> {
    let of = |(index, name): (usize, &String)| {
        let stretches: Vec<Channels> =
            judged.stretches.iter().filter(|s| s.recording == index).cloned().collect();
        let mut design = DesignMatrix::new(&stretches, cutoff, judged.reversals, fitted.design.delay)?;
        design.model_force(acting);
        let curves = fitted.followed.iter().flat_map(|f| f.columns(&design, &judged.extra));
        let curves: Vec<_> = curves.collect();
        design.baseline.extend(curves);
        Some(Judge { index, name: name.clone(), design })
    };
    judged.names.iter().enumerate().filter_map(of).collect()
}

/// What is frozen.
pub(crate) struct Frozen<'a> {
    /// The design matrix it was fitted on.
    pub design: &'a DesignMatrix,
    pub baseline: &'a Hypothesis,
    pub found: &'a Hypothesis,
    /// Nuisances that may differ there.
    pub declared: &'a [Nuisance],
    /// Position is zero at the same place in every recording.
    pub absolute: bool,
}

/// A nuisance with its estimate and standard deviation.
type Fitted = (Nuisance, f64, f64);

impl Frozen<'_> {
    /// Judges each recording by itself.
    pub fn judge(&self, judges: &[Judge], geometry: Geometry) -> Vec<Validation> {
        judges.iter().map(|j| self.one(&j.design, j.index, &j.name, geometry)).collect()
    }

    /// Squared error of a hypothesis on all of `judges`. Declared nuisances are fitted again.
    pub fn squared(&self, judges: &[Judge], hypothesis: &Hypothesis) -> f64 {
        let of = |j: &Judge| {
            if !self.declared.is_empty() {
                return self.refit(&j.design, j.index, hypothesis).0;
            }
            let rest = self.rest(&j.design, hypothesis, self.absolute);
            dot(&rest, &rest)
        };
        judges.iter().map(of).sum()
    }

    /// The same as a root mean square.
    pub fn rms(&self, judges: &[Judge], hypothesis: &Hypothesis) -> f64 {
        let rows: f64 = judges.iter().flat_map(|j| j.design.block_weight()).sum();
        (self.squared(judges, hypothesis) / rows.max(1.0)).sqrt()
    }

    fn one(&self, design: &DesignMatrix, index: usize, name: &str, geometry: Geometry) -> Validation {
        let rows = design.effective_rows();
        let size = dot(&design.y, &design.y).max(1e-300);
        let square = |rest: &[f64]| dot(rest, rest);
        let before = square(&self.rest(design, self.baseline, self.absolute));
        let after = square(&self.rest(design, self.found, self.absolute));
        let again = (!self.declared.is_empty()).then(|| {
            let (before, _) = self.refit(design, index, self.baseline);
            let (after, fitted) = self.refit(design, index, self.found);
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
                    unit: nuisance.parameter().unit(geometry).to_string(),
                })
                .collect(),
        }
    }

    /// What a frozen hypothesis leaves. Unless `phases` hold there, the mean of a periodic effect over its phase, zero,
    /// is all that is known of it.
    fn rest(&self, design: &DesignMatrix, hypothesis: &Hypothesis, phases: bool) -> Vec<f64> {
        let mut rest = design.y.clone();
        let mut take = |column: &[f64], c: f64| {
            for (r, x) in rest.iter_mut().zip(column) {
                *r -= c * x;
            }
        };
        let coefficients = &hypothesis.fit.coefficients;
        let physics = self.design.physics(coefficients);
        for (column, i) in design.baseline.iter().zip(&design.present) {
            take(column, physics[*i]);
        }
        // nuisances of the recordings that were fitted are none of this one
        if design.delay {
            take(&design.baseline[design.present.len()], coefficients[self.design.present.len()]);
        }
        // further columns come last in either baseline
        let followed = &design.baseline[design.present.len() + usize::from(design.delay)..];
        let last = self.design.baseline.len();
        for (column, c) in followed.iter().zip(&coefficients[last - followed.len()..last]) {
            take(column, *c);
        }
        for term in &hypothesis.free {
            take(&term.contribution(design), 1.0);
        }
        for (i, atom) in hypothesis.atoms.iter().enumerate() {
            if !phases && atom.term.kind.is_periodic() {
                continue;
            }
            let columns = design.columns(&atom.term);
            for (a, c) in atom.active.iter().zip(hypothesis.coefficients(self.design, i)) {
                if let Some(column) = columns.get(*a) {
                    take(column, *c);
                }
            }
        }
        rest
    }

    /// Least squared error over the declared nuisances, and where it is reached.
    fn refit(&self, design: &DesignMatrix, index: usize, hypothesis: &Hypothesis) -> (f64, Vec<Fitted>) {
        let linear: Vec<(Nuisance, Vec<f64>)> = self
            .declared
            .iter()
            .filter_map(|&n| design.nuisance_column(n, None).map(|column| (n, column)))
            .collect();
        let columns: Vec<&[f64]> = linear.iter().map(|(_, c)| c.as_slice()).collect();
        // none of these columns is an acceleration with noise of its own
        let blocks = Blocks { noise: Vec::new(), ..design.blocks.clone() };
        let with = |design: &DesignMatrix| -> (f64, Vec<Fitted>) {
            let phases = self.absolute || self.declared.contains(&Nuisance::Origin);
            let rest = self.rest(design, hypothesis, phases);
            match fit(&columns, &rest, &blocks, 4) {
                Some(f) => {
                    let values = f.coefficients.iter().zip(f.std_errors());
                    let fitted = linear.iter().zip(values).map(|((n, _), (v, s))| (*n, *v, *s)).collect();
                    (dot(&f.residual, &f.residual), fitted)
                }
                None => (dot(&rest, &rest), Vec::new()),
            }
        };
        let still = with(design);
        if !self.declared.contains(&Nuisance::Origin) {
            return still;
        }
        let (low, high) = design
            .tracks
            .iter()
            .flat_map(|t| &t.x)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let span = high - low;
        let error = |shift: f64| with(&design.shifted(index, shift)).0;
        // what was found may not depend on position at all
        if (error(0.01 * span) - still.0).abs() <= 1e-9 * still.0 {
            return still;
        }
        let rows = design.effective_rows();
        let (best, least) = nearest(0.5 * span, span, |least| MIN_CHI_SQUARE * least / rows.max(1.0), error);
        let h = 0.0025 * span;
        let bend = (error(best + h) + error(best - h) - 2.0 * least) / (h * h);
        let std = if bend > 0.0 { (2.0 * least / rows.max(1.0) / bend).sqrt() } else { f64::NAN };
        let (least, mut fitted) = with(&design.shifted(index, best));
        fitted.push((Nuisance::Origin, best, std));
        (least, fitted)
    }
}
