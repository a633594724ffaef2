//! A free form as columns of the regression.

use crate::free_form::candidate::is_cut;
use crate::library::design_matrix::DesignMatrix;
use crate::regression::linear::gram;
use friction::{FreeForm, FreeFormState};
use nalgebra::DMatrix;
use rayon::prelude::*;
use signals::{Basis, dot, subtract_scaled};
use std::sync::{Arc, OnceLock};

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

/// Columns of which terms of one form hold the same.
pub type Shared = Arc<Vec<Vec<f64>>>;

/// A free form in a regression. Its values at the knots are not independent of what is already there (a
/// constant is a friction level, a straight line viscous friction), so the columns are the directions that are.
#[derive(Debug, Clone)]
pub struct FreeTerm {
    /// Coordinates, knots and factor; the values are those of the last fit.
    pub form: FreeForm<f64>,
    /// A column for each value.
    all: Shared,
    /// Independent columns; of a form with penalties or fewer directions than values, the smoothest first.
    pub columns: Shared,
    /// Penalties of their coefficients.
    pub penalties: Vec<f64>,
    /// Values at the knots for a unit of each column.
    modes: Vec<Vec<f64>>,
    /// Number of directions that were asked for.
    pub freedom: usize,
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

/// The directions of a form's values that a basis does not hold.
pub struct Directions {
    form: FreeForm<f64>,
    all: Shared,
    /// Inner products of the columns outside the span of the basis.
    gram: DMatrix<f64>,
    /// Largest squared length of a column.
    whole: f64,
    /// The smoothest first.
    smooth: Vec<Direction>,
    /// Their columns, once a smoothing spline has asked for them.
    columns: OnceLock<Shared>,
    /// Straight lines that a form which is no smoothing spline leaves to the basis.
    lines: Vec<Line>,
}

/// A straight line whose column is in the span of the basis, as over the velocity.
struct Line {
    values: Vec<f64>,
    /// Weight of each value of a form in its slope.
    weights: Vec<f64>,
}

/// A direction of the values, of length one.
struct Direction {
    values: Vec<f64>,
    /// Squared length of its column outside of the basis.
    power: f64,
    /// That, over the roughness of the values.
    smoothness: f64,
}

impl Directions {
    /// `all` has a column for each value. None where nothing is outside of the span of `basis`.
    pub fn new(basis: &Basis, form: FreeForm<f64>, all: Shared) -> Option<Self> {
        let rest: Vec<Vec<f64>> = all.par_iter().map(|c| basis.project_out(c)).collect();
        let gram = gram(&rest, 0..rest.first()?.len());
        if gram.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let whole = all.iter().map(|c| dot(c, c)).fold(0.0, f64::max);
        let second = form.across.map_or(1, |(_, knots)| knots.places().len());
        let smooth = determined(smoothest(&gram, (all.len() / second, second))?, whole);
        let lines = if is_spline(&form) { Vec::new() } else { lines(form.knots.places(), &all, &rest) };
        (!smooth.is_empty()).then(|| Self { form, all, gram, whole, smooth, columns: OnceLock::new(), lines })
    }

    /// The values of a direction without their slope. The basis keeps it, and goes on beyond the knots, where the form is level.
    fn without_slope(&self, direction: &Direction) -> Vec<f64> {
        let mut values = direction.values.clone();
        for line in &self.lines {
            let slope = dot(&values, &line.weights);
            subtract_scaled(&mut values, slope, &line.values);
        }
        values
    }

    /// The form with about as many free directions as `freedom`. A map and most curves are smoothing splines: a motion may tell
    /// of a part of them only. Others are cut after their smoothest directions, or have all of their values free.
    pub fn term(&self, freedom: usize) -> FreeTerm {
        let Self { form, all, smooth, .. } = self;
        let columns = |modes: &[Vec<f64>]| Arc::new(modes.iter().map(|m| combine(all, m)).collect());
        let term = |modes: Vec<Vec<f64>>, columns: Shared, penalties: Vec<f64>| FreeTerm {
            form: *form,
            all: all.clone(),
            columns,
            penalties,
            modes,
            freedom,
            std: vec![0.0; all.len()],
        };
        let cut = |of: &[Direction]| {
            let modes: Vec<Vec<f64>> = of.iter().map(|d| self.without_slope(d)).collect();
            let columns = columns(&modes);
            term(modes, columns, vec![0.0; of.len()])
        };
        if is_spline(form) {
            let half = smooth.get(freedom).map_or(0.0, |d| d.smoothness);
            let penalty = |d: &Direction| if half > 0.0 { d.power * half / d.smoothness } else { 0.0 };
            let modes: Vec<Vec<f64>> = smooth.iter().map(|d| d.values.clone()).collect();
            let shared = self.columns.get_or_init(|| columns(&modes)).clone();
            term(modes, shared, smooth.iter().map(penalty).collect())
        } else if freedom < all.len() {
            cut(&smooth[..freedom.min(smooth.len())])
        } else {
            cut(&determined(strongest(&self.gram), self.whole))
        }
    }
}

/// Whether a form is a smoothing spline: a map and most curves are.
fn is_spline(form: &FreeForm<f64>) -> bool {
    form.across.is_some() || !is_cut(form.over)
}

/// The straight line over a curve's knots, or its halves on either side of zero, as far as the basis holds their columns; `rest` is
/// what is outside the basis of each column in `all`. The slope is that over the outer half of the knots.
fn lines(places: &[f64], all: &[Vec<f64>], rest: &[Vec<f64>]) -> Vec<Line> {
    let far = places.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
    let line = |shape: fn(f64) -> f64| {
        let values: Vec<f64> = places.iter().map(|p| shape(*p)).collect();
        let (column, outside) = (combine(all, &values), combine(rest, &values));
        let power = dot(&column, &column);
        if !(dot(&outside, &outside) <= OUTSIDE * power && power > 0.0) {
            return None;
        }
        let outer = |v: &f64| v.abs() >= 0.5 * far;
        let count = values.iter().filter(|v| outer(v)).count() as f64;
        let mean = values.iter().filter(|v| outer(v)).sum::<f64>() / count;
        let from_mean = |v: &f64| if outer(v) { v - mean } else { 0.0 };
        let spread: f64 = values.iter().map(|v| from_mean(v).powi(2)).sum();
        let weights = values.iter().map(|v| from_mean(v) / spread).collect();
        (spread > 0.0).then_some(Line { values, weights })
    };
    match (line(|p| p.max(0.0)), line(|p| p.min(0.0))) {
        (None, None) => line(|p| p).into_iter().collect(),
        (forward, backward) => forward.into_iter().chain(backward).collect(),
    }
}

/// The directions that the samples determine.
fn determined(mut directions: Vec<Direction>, whole: f64) -> Vec<Direction> {
    let power = directions.iter().map(|d| d.power).fold(0.0, f64::max);
    directions.retain(|d| d.power > (DETERMINED * power).max(OUTSIDE * whole));
    directions
}

/// Directions of the values with the most power in the samples first.
fn strongest(gram: &DMatrix<f64>) -> Vec<Direction> {
    let eigen = gram.clone().symmetric_eigen();
    let direction = |k: usize| Direction {
        values: eigen.eigenvectors.column(k).iter().copied().collect(),
        power: eigen.eigenvalues[k],
        smoothness: eigen.eigenvalues[k],
    };
    let mut out: Vec<Direction> = (0..gram.nrows()).map(direction).collect();
    out.sort_by(|a, b| b.power.total_cmp(&a.power));
    out
}

impl FreeTerm {
    /// The same form outside the span of another basis.
    pub fn outside(&self, basis: &Basis) -> Option<Self> {
        Some(Directions::new(basis, self.form, self.all.clone())?.term(self.freedom))
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

    /// Columns that are free, or keep more than half of their unpenalized coefficient.
    pub fn free_columns(&self) -> &[Vec<f64>] {
        &self.columns[..self.freedom.min(self.columns.len())]
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

/// Directions of the values in the basis of [demmler-reinsch-1975], smoothest first: a smoothing spline shrinks each on its own.
/// The roughness of a map is the sum of that along either axis [eilers-2003]; these are the numbers of values on each.
fn smoothest(gram: &DMatrix<f64>, (first, second): (usize, usize)) -> Option<Vec<Direction>> {
    let one = DMatrix::identity;
    let rough =
        roughness(first).kronecker(&one(second, second)) + one(first, first).kronecker(&roughness(second));
    let lower = rough.cholesky()?.l();
    let half = lower.solve_lower_triangular(gram)?;
    let both = lower.solve_lower_triangular(&half.transpose())?;
    let upper = lower.transpose();
    let eigen = (0.5 * (&both + both.transpose())).symmetric_eigen();
    let direction = |k: usize| {
        let values = upper.solve_upper_triangular(&eigen.eigenvectors.column(k).into_owned())?;
        let (size, smoothness) = (values.norm(), eigen.eigenvalues[k]);
        let values = values.iter().map(|x| x / size).collect();
        Some(Direction { values, power: smoothness / (size * size), smoothness })
    };
    let mut out: Vec<Direction> = (0..gram.nrows()).map(direction).collect::<Option<_>>()?;
    out.sort_by(|a, b| b.smoothness.total_cmp(&a.smoothness));
    Some(out)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_form::describe::joint;
    use crate::preparation::track::Reversals;
    use crate::search::hypothesis::Hypothesis;
    use friction::{Coordinate, Factor, Knots};
    use signals::Channels;
    use std::f64::consts::TAU;

    #[test]
    fn a_curve_over_the_velocity_took_the_slope_of_what_is_beyond_it() {
        const DT: f64 = 1e-3;
        // friction that rises at low speed, then as 4 N·s/m
        let friction = |v: f64| 1.5 * v.signum() + 0.6 * (v / 0.01).tanh() + 4.0 * v;
        let tones = [(0.02, 0.5), (0.01, 0.83), (0.004, 1.7)];
        let (mut position, mut force) = (Vec::new(), Vec::new());
        for i in 0..16_000 {
            let t = DT * f64::from(i);
            let sum =
                |of: fn(f64, f64, f64) -> f64| tones.iter().map(|(a, f)| of(*a, TAU * f, t)).sum::<f64>();
            let v = sum(|a, w, t| a * w * (w * t).cos());
            position.push(sum(|a, w, t| a * (w * t).sin()) + 1e-7 * (1e3 * t * t).sin());
            force.push(
                0.5 * sum(|a, w, t| -a * w * w * (w * t).sin()) + friction(v) + 0.02 * (7e3 * t * t).sin(),
            );
        }
        let channels = Channels { dt: DT, position, force, ..Channels::default() };
        let design = DesignMatrix::new(&[channels], 50.0, Reversals::default(), false).unwrap();
        let baseline = Hypothesis::new(&design, Vec::new()).unwrap();
        let places: Vec<f64> = (0..15).map(|k| 0.0225 * f64::from(k - 7)).collect();
        let form =
            FreeForm::curve(Coordinate::Velocity, Factor::One, Knots::new(&places).unwrap(), &[0.0; 15])
                .unwrap();
        let all = Arc::new(design.free_columns(&form));
        let term = Directions::new(&Basis::of(&design.baseline), form, all).unwrap().term(15);
        let (plain, beside) = (baseline.fit.clone(), joint(&design, &baseline, &[term]).unwrap());
        let of = |c: &[f64]| (design.physics(c)[3], design.physics(c)[4]);
        println!("alone {:.2?}, beside a curve {:.2?}", of(&plain.coefficients), of(&beside.coefficients));
        let (forward, backward) = of(&beside.coefficients);
        assert!((forward - 4.0).abs() < 0.3 && (backward - 4.0).abs() < 0.3);
        assert!(beside.heldout_sum() < 0.2 * plain.heldout_sum());
    }
}
