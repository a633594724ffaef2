//! Simulation error: the parameters whose free runs come closest to the recording.

use crate::data::Record;
use crate::free_run::free_run;
use crate::place::Place;
use crate::plant::Plant;
use crate::settle::settled;
use friction::Scalar;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt, TerminationReason};
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use num_dual::Dual64;
use rayon::prelude::*;
use std::ops::Range;

/// A mass below this share of where it began is as good as none.
const LEAST_MASS: f64 = 1e-3;
/// Most blocks of samples whose sums are taken for independent in a standard error. A block is a window at least: within
/// one the error of a run grows.
const BLOCKS: usize = 50;

/// Parameters with their standard errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// One value for each place.
    pub values: Vec<f64>,
    /// Standard errors. The error of a free run is correlated over long times: they are taken from how sums over blocks of
    /// the recording scatter.
    pub std: Vec<f64>,
    /// Root mean square error of the free runs, m.
    pub rms: f64,
    /// Runs of all windows.
    pub evaluations: usize,
    /// The minimiser ended at a minimum.
    pub converged: bool,
}

impl Fitted {
    /// Parameters from elsewhere, without standard errors.
    #[must_use]
    pub fn given(values: &[f64]) -> Self {
        Self {
            values: values.to_vec(),
            std: vec![f64::NAN; values.len()],
            rms: f64::NAN,
            evaluations: 0,
            converged: true,
        }
    }
}

/// Errors of a free run over a window, model less measured, m, without the samples that set the state. None of a window
/// that is shorter, or beyond the record.
pub(crate) fn errors<S: Scalar>(
    plant: &Plant<S>,
    value: &Plant<f64>,
    record: &Record,
    window: &Range<usize>,
    settling: usize,
) -> Vec<S> {
    let window = &(window.start..window.end.min(record.len()));
    if window.len() <= settling.max(2) {
        return Vec::new();
    }
    let start = settled(plant, value, record, window, settling);
    let run = free_run(plant, &record.drive, window.start, window.len(), start, record.bound);
    let measured = &record.position[window.clone()];
    run.iter().zip(measured).skip(settling).map(|(x, y)| *x - S::lit(*y)).collect()
}

/// Fits the parameters at `places` to free runs over `windows` of a record by Levenberg-Marquardt, from `start`.
///
/// Each run begins in the state that its first `settling` samples give. `scales` are changes of the parameters of like
/// effect. Derivatives are exact: the same run on dual numbers.
#[must_use]
pub fn fit(
    places: &[Place],
    start: &[f64],
    scales: &[f64],
    record: &Record,
    windows: &[Range<usize>],
    settling: usize,
) -> Fitted {
    let problem =
        Problem { places, start, scales, record, windows, settling, at: DVector::zeros(places.len()) };
    let (problem, report) = LevenbergMarquardt::new()
        .with_ftol(1e-9)
        .with_xtol(1e-7)
        .with_gtol(1e-9)
        .with_patience(8)
        .minimize(problem);
    let residuals = problem.errors();
    let converged = report.termination.was_successful()
        || matches!(report.termination, TerminationReason::NoImprovementPossible(_));
    let std = problem.standard_errors(&residuals);
    Fitted {
        values: problem.values(),
        std,
        rms: signals::rms(residuals.as_slice()),
        evaluations: report.number_of_evaluations,
        converged,
    }
}

struct Problem<'a> {
    places: &'a [Place],
    start: &'a [f64],
    scales: &'a [f64],
    record: &'a Record,
    windows: &'a [Range<usize>],
    settling: usize,
    /// Distance from the start, in scales.
    at: DVector<f64>,
}

impl Problem<'_> {
    fn values(&self) -> Vec<f64> {
        let at = |i: usize| {
            let value = self.start[i] + self.at[i] * self.scales[i];
            if self.places[i] == Place::Mass { value.max(LEAST_MASS * self.start[i]) } else { value }
        };
        (0..self.places.len()).map(at).collect()
    }

    fn errors(&self) -> DVector<f64> {
        let plant = Plant::new(self.places, &self.values());
        let runs: Vec<Vec<f64>> =
            self.windows.par_iter().map(|w| errors(&plant, &plant, self.record, w, self.settling)).collect();
        DVector::from_vec(runs.concat())
    }

    fn derivatives(&self) -> DMatrix<f64> {
        let values = self.values();
        let plant = Plant::new(self.places, &values);
        let jobs: Vec<(usize, &Range<usize>)> =
            (0..self.places.len()).flat_map(|k| self.windows.iter().map(move |w| (k, w))).collect();
        let parts: Vec<Vec<f64>> = jobs
            .par_iter()
            .map(|(k, window)| {
                let seeded: Vec<Dual64> = values
                    .iter()
                    .enumerate()
                    .map(|(i, v)| if i == *k { Dual64::from(*v).derivative() } else { Dual64::from(*v) })
                    .collect();
                let moved = Plant::new(self.places, &seeded);
                let run = errors(&moved, &plant, self.record, window, self.settling);
                run.iter().map(|e| e.eps * self.scales[*k]).collect()
            })
            .collect();
        let flat = parts.concat();
        DMatrix::from_vec(flat.len() / self.places.len().max(1), self.places.len(), flat)
    }

    /// (JᵀJ)⁻¹ (Σ g gᵀ) (JᵀJ)⁻¹, where g is the gradient of one block.
    fn standard_errors(&self, residuals: &DVector<f64>) -> Vec<f64> {
        let jacobian = self.derivatives();
        let parameters = self.places.len();
        let undetermined = vec![f64::NAN; parameters];
        let Some(inverse) = jacobian.tr_mul(&jacobian).cholesky().map(|c| c.inverse()) else {
            return undetermined;
        };
        let window = if self.windows.len() > 1 { residuals.len() / self.windows.len() } else { 1 };
        let block = residuals.len().div_ceil(BLOCKS).max(window).max(1);
        let mut middle = DMatrix::zeros(parameters, parameters);
        for first in (0..residuals.len()).step_by(block) {
            let rows = block.min(residuals.len() - first);
            let gradient = jacobian.rows(first, rows).tr_mul(&residuals.rows(first, rows));
            middle += &gradient * gradient.transpose();
        }
        // the residuals of as many blocks as there are parameters could vanish
        let blocks = residuals.len().div_ceil(block) as f64;
        let free = blocks - parameters as f64;
        if !(free > 0.0) {
            return undetermined;
        }
        let covariance = &inverse * middle * &inverse * (blocks / free);
        (0..parameters).map(|i| covariance[(i, i)].sqrt() * self.scales[i]).collect()
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.at.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.errors()).filter(|r| r.iter().all(|e| e.is_finite()))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.derivatives()).filter(|j| j.iter().all(|e| e.is_finite()))
    }
}
