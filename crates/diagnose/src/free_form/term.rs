//! A free form as columns of the regression.

use crate::library::design_matrix::DesignMatrix;
use friction::{FreeForm, FreeFormState};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use signals::{Basis, dot};
use std::sync::Arc;

/// Smallest share of the strongest direction from which on a direction of the values is determined.
const DETERMINED: f64 = 1e-3;
/// Smallest share that must lie outside of what is already in the model.
const OUTSIDE: f64 = 1e-4;
/// Weight of slopes in the roughness; bends have 1. It makes a curve level off where there is no data.
const SLOPE: f64 = 0.05;
/// Ridge that keeps the roughness positive definite: a constant has no slope and no bend.
const ROUGH: f64 = 1e-6;

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
    /// Most columns that are kept.
    pub most: usize,
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

/// What a form adds to a basis, before it is said how many of its directions are free.
pub struct Addition {
    form: FreeForm<f64>,
    all: Arc<Vec<Vec<f64>>>,
    /// Inner products of its columns outside the span of the basis.
    gram: DMatrix<f64>,
    /// Largest squared length of a column.
    whole: f64,
}

impl Addition {
    /// `all` has a column for each value. None where there is no number.
    pub fn new(basis: &Basis, form: FreeForm<f64>, all: Arc<Vec<Vec<f64>>>) -> Option<Self> {
        let rest: Vec<Vec<f64>> = all.par_iter().map(|c| basis.project_out(c)).collect();
        let gram = DMatrix::from_fn(all.len(), all.len(), |i, j| dot(&rest[i], &rest[j]));
        let whole = all.iter().map(|c| dot(c, c)).fold(0.0, f64::max);
        gram.iter().all(|x| x.is_finite()).then_some(Self { form, all, gram, whole })
    }

    /// At most `most` independent columns; if that is fewer than there are values, the smoothest. None if there are none.
    pub fn term(&self, most: usize) -> Option<FreeTerm> {
        let count = self.all.len();
        let directions = if most < count { smoothest(&self.gram)? } else { strongest(self.gram.clone()) };
        let power = directions.iter().map(|(power, _)| *power).fold(0.0, f64::max);
        let determined = |power_of: f64| power_of > (DETERMINED * power).max(OUTSIDE * self.whole);
        let determined = directions.into_iter().filter(|(power, _)| determined(*power));
        let modes: Vec<Vec<f64>> = determined.map(|(_, mode)| mode).take(most).collect();
        let columns: Vec<Vec<f64>> = modes.iter().map(|mode| combine(&self.all, mode)).collect();
        let (form, all, std) = (self.form, self.all.clone(), vec![0.0; count]);
        (!columns.is_empty()).then(|| FreeTerm { form, all, columns, modes, most, std })
    }
}

impl FreeTerm {
    /// The same form outside the span of another basis.
    pub fn outside(&self, basis: &Basis) -> Option<Self> {
        Addition::new(basis, self.form, self.all.clone())?.term(self.most)
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

/// Directions of the values, each with its power in the samples, strongest first.
fn strongest(gram: DMatrix<f64>) -> Vec<(f64, Vec<f64>)> {
    let eigen = gram.symmetric_eigen();
    let column = |k: usize| eigen.eigenvectors.column(k).iter().copied().collect();
    let mut out: Vec<(f64, Vec<f64>)> =
        (0..eigen.eigenvalues.len()).map(|k| (eigen.eigenvalues[k], column(k))).collect();
    out.sort_by(|a, b| b.0.total_cmp(&a.0));
    out
}

/// The same in the basis of [demmler-reinsch-1975], smoothest first: the lighter the penalty, the more of these directions a
/// smoothing spline follows.
fn smoothest(gram: &DMatrix<f64>) -> Option<Vec<(f64, Vec<f64>)>> {
    let lower = roughness(gram.nrows()).cholesky()?.l();
    let half = lower.solve_lower_triangular(gram)?;
    let both = lower.solve_lower_triangular(&half.transpose())?;
    let upper = lower.transpose();
    let mode = |(power, direction): (f64, Vec<f64>)| {
        let mode = upper.solve_upper_triangular(&DVector::from_vec(direction))?;
        let size = mode.norm();
        Some((power / (size * size), mode.iter().map(|x| x / size).collect()))
    };
    strongest(0.5 * (&both + both.transpose())).into_iter().map(mode).collect()
}

/// Quadratic form of the values of a curve: squares of its bends and, weaker, of its slopes.
fn roughness(count: usize) -> DMatrix<f64> {
    let mut out = DMatrix::from_diagonal_element(count, count, ROUGH);
    for (weight, difference) in [(SLOPE, &[-1.0, 1.0][..]), (1.0, &[1.0, -2.0, 1.0])] {
        for from in 0..(count + 1).saturating_sub(difference.len()) {
            for (i, a) in difference.iter().enumerate() {
                for (j, b) in difference.iter().enumerate() {
                    out[(from + i, from + j)] += weight * a * b;
                }
            }
        }
    }
    out
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
