//! A free form as columns of the regression.

use crate::library::design_matrix::DesignMatrix;
use friction::{FreeForm, FreeFormState};
use nalgebra::DMatrix;
use rayon::prelude::*;
use signals::{Basis, dot};
use std::sync::Arc;

/// Smallest share of the strongest direction from which on a direction of the values is determined.
const DETERMINED: f64 = 1e-3;
/// Smallest share that must lie outside of what is already in the model.
const OUTSIDE: f64 = 1e-4;

/// Columns that go through the filter together.
const LANES: usize = 8;

/// A free form in a regression. Its values at the knots are not independent of what is already there (a constant is a
/// friction level, a straight line viscous friction), so the columns are the directions that are.
#[derive(Debug, Clone)]
pub struct FreeTerm {
    /// Coordinates, knots and factor; the values are those of the last fit.
    pub form: FreeForm<f64>,
    /// A column for each value.
    all: Arc<Vec<Vec<f64>>>,
    /// Independent columns.
    pub columns: Vec<Vec<f64>>,
    /// Values at the knots for a unit of each column.
    modes: Vec<Vec<f64>>,
    /// Standard deviation of each value; zeros before a fit.
    pub std: Vec<f64>,
}

impl DesignMatrix {
    /// Columns of a free form, one for each of its values.
    pub fn free_columns(&self, form: &FreeForm<f64>) -> Vec<Vec<f64>> {
        let of_group = |group: usize| {
            let first = group * LANES;
            let series = self.walk(FreeFormState::default, |state, motion| {
                let mut lanes = [0.0; LANES];
                form.weights(state, motion, |i, w| {
                    if let Some(lane) = i.checked_sub(first).and_then(|lane| lanes.get_mut(lane)) {
                        *lane += w;
                    }
                });
                lanes
            });
            let mut out: [Vec<f64>; LANES] = std::array::from_fn(|_| Vec::with_capacity(self.share.len()));
            for (track, series) in self.tracks.iter().zip(series) {
                track.passed_rows(series, &mut out);
            }
            out
        };
        let groups = (0..form.count().div_ceil(LANES)).into_par_iter();
        let mut columns: Vec<Vec<f64>> = groups.flat_map_iter(of_group).collect();
        columns.truncate(form.count());
        columns
    }
}

impl FreeTerm {
    /// The same form outside the span of another basis.
    pub fn outside(&self, basis: &Basis) -> Option<Self> {
        Self::new(basis, self.form, self.all.clone())
    }

    /// The directions of `form` outside the span of `basis`; None where there is none. `all` are its columns.
    pub fn new(basis: &Basis, form: FreeForm<f64>, all: Arc<Vec<Vec<f64>>>) -> Option<Self> {
        let rest: Vec<Vec<f64>> = all.par_iter().map(|c| basis.project_out(c)).collect();
        let count = all.len();
        let gram = DMatrix::from_fn(count, count, |i, j| dot(&rest[i], &rest[j]));
        if gram.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let whole = all.iter().map(|c| dot(c, c)).fold(0.0, f64::max);
        let eigen = gram.symmetric_eigen();
        let most = eigen.eigenvalues.max();
        let mut order: Vec<usize> =
            (0..count).filter(|k| eigen.eigenvalues[*k] > (DETERMINED * most).max(OUTSIDE * whole)).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let modes: Vec<Vec<f64>> =
            order.iter().map(|k| eigen.eigenvectors.column(*k).iter().copied().collect()).collect();
        let columns: Vec<Vec<f64>> = modes.iter().map(|mode| combine(&all, mode)).collect();
        (!columns.is_empty()).then(|| Self { form, all, columns, modes, std: vec![0.0; count] })
    }

    /// The same with the values of a fit.
    pub fn fitted(mut self, coefficients: &[f64], std: &[f64]) -> Self {
        let values = combine(&self.modes, coefficients);
        self.std = (0..values.len())
            .map(|k| self.modes.iter().zip(std).map(|(m, s)| (m[k] * s).powi(2)).sum::<f64>().sqrt())
            .collect();
        if let Ok(form) = self.form.with_values(&values) {
            self.form = form;
        }
        self
    }

    /// Whether it depends on the time since the start: one half of a recording says nothing about the other.
    pub fn is_of_time(&self) -> bool {
        self.form.is_of_time()
    }

    /// What it adds on another design matrix.
    pub fn contribution(&self, design: &DesignMatrix) -> Vec<f64> {
        combine(&design.free_columns(&self.form), self.form.values())
    }
}

/// Σ share·column.
fn combine(columns: &[Vec<f64>], shares: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, share) in columns.iter().zip(shares) {
        for (s, x) in sum.iter_mut().zip(column) {
            *s += share * x;
        }
    }
    sum
}
