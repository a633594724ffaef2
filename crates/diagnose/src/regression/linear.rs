//! Least squares over few columns and many rows: blocked cross-validation, robust standard errors.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use signals::{dot, subtract_scaled};
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::borrow::Borrow;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Groups of blocks left out in turn.
pub const FOLDS: usize = 10;

/// Rows that belong together: the unit of resampling and of cross-validation.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Blocks {
    /// First row of each block, and the end of the last.
    pub edges: Vec<usize>,
    /// True where a block starts another recording or segment.
    pub starts: Vec<bool>,
    /// Recording of each block; empty when there is one only.
    pub recordings: Vec<usize>,
    /// Squared noise of the first column, the mass's acceleration, in each block; empty when it has none.
    pub noise: Vec<f64>,
    /// Coefficient of the first column whose share of the error counts as noise of the recording.
    pub mass: f64,
}

impl Blocks {
    /// Squared noise of the first column in block `k`.
    fn noise_of(&self, k: usize) -> f64 {
        self.noise.get(k).copied().unwrap_or(0.0)
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.edges.len().saturating_sub(1)
    }

    /// Rows of block `k`.
    pub fn rows(&self, k: usize) -> Range<usize> {
        self.edges[k]..self.edges[k + 1]
    }
}

/// Normal equations of one block.
#[derive(Debug)]
struct Normal {
    gram: DMatrix<f64>,
    moment: DVector<f64>,
}

/// A least-squares fit and how it does on blocks it has not seen.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Coefficients over all rows.
    pub coefficients: Vec<f64>,
    /// Cluster-robust standard errors, once they were asked for.
    std_errors: OnceLock<Vec<f64>>,
    /// What they follow from.
    known: Arc<Known>,
    /// Residual over all rows.
    pub residual: Vec<f64>,
    /// Squared error of each block, predicted by a fit without it and its neighbours.
    pub heldout: Vec<f64>,
    /// Prediction of each row by the fit that did not see its block.
    pub heldout_prediction: Vec<f64>,
}

/// Normal equations of all blocks. Fits of the same columns with other penalties share them.
#[derive(Debug)]
pub struct Normals {
    blocks: Vec<Normal>,
    gram: DMatrix<f64>,
    moment: DVector<f64>,
    /// 1 where the acceleration's own noise is taken off, else 0.
    corrected: f64,
}

/// Normal equations, with the penalties in the Gram matrix.
#[derive(Debug)]
struct Known {
    normals: Arc<Normals>,
    gram: DMatrix<f64>,
    factored: Factored,
}

impl Fit {
    /// Cluster-robust standard errors: the jackknife over blocks. Most fits of a search are compared by what they hold out and
    /// never asked for them.
    pub fn std_errors(&self) -> &[f64] {
        self.std_errors.get_or_init(|| self.known.std_errors())
    }

    /// Replaces the standard errors.
    pub fn set_std_errors(&mut self, std_errors: Vec<f64>) {
        self.std_errors = OnceLock::from(std_errors);
    }

    /// Held-out squared error.
    pub fn heldout_sum(&self) -> f64 {
        self.heldout.iter().sum()
    }
}

fn normal<C: Borrow<[f64]>>(columns: &[C], y: &[f64], rows: Range<usize>) -> Normal {
    let y = &y[rows.clone()];
    let moment = DVector::from_fn(columns.len(), |i, _| dot(&columns[i].borrow()[rows.clone()], y));
    Normal { gram: gram(columns, rows), moment }
}

/// Inner products of the columns.
pub fn gram<C: Borrow<[f64]>>(columns: &[C], rows: Range<usize>) -> DMatrix<f64> {
    let p = columns.len();
    let mut gram = DMatrix::zeros(p, p);
    for i in 0..p {
        let a = &columns[i].borrow()[rows.clone()];
        for j in 0..=i {
            let g = dot(a, &columns[j].borrow()[rows.clone()]);
            gram[(i, j)] = g;
            gram[(j, i)] = g;
        }
    }
    gram
}

/// A Gram matrix with penalties on its diagonal.
fn penalized(mut gram: DMatrix<f64>, penalties: &[f64]) -> DMatrix<f64> {
    for (i, penalty) in penalties.iter().enumerate() {
        gram[(i, i)] += penalty;
    }
    gram
}

/// A Gram matrix of unit diagonal, factored, and what its rows were scaled by.
#[derive(Debug)]
struct Factored {
    scale: DVector<f64>,
    unit: Cholesky<f64, Dyn>,
}

impl Factored {
    /// None when the matrix is singular.
    fn new(gram: &DMatrix<f64>) -> Option<Self> {
        let p = gram.nrows();
        let scale = gram.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
        if scale.iter().any(|s| *s == 0.0 || !s.is_finite()) {
            return None;
        }
        let unit = DMatrix::from_fn(p, p, |i, j| {
            gram[(i, j)] * scale[i] * scale[j] + if i == j { 1e-11 } else { 0.0 }
        });
        Some(Self { scale, unit: unit.cholesky()? })
    }

    /// The coefficients of a moment. An inverse of many columns would take longer than all the rest of a fit.
    fn solve(&self, moment: &DVector<f64>) -> DVector<f64> {
        let mut out = moment.component_mul(&self.scale);
        self.unit.solve_mut(&mut out);
        out.component_mul_assign(&self.scale);
        out
    }
}

/// Inverse of a Gram matrix, scaled to unit diagonal first; None when it is singular.
pub fn inverse(gram: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let Factored { scale, unit } = Factored::new(gram)?;
    let inverse = unit.inverse();
    Some(DMatrix::from_fn(gram.nrows(), gram.nrows(), |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}

/// Least squares with penalties as of [`Normals::fit`]; none when the columns are dependent.
pub fn solve<C: Borrow<[f64]>>(columns: &[C], penalties: &[f64], y: &[f64]) -> Option<Vec<f64>> {
    let whole = normal(columns, y, 0..y.len());
    let solution = Factored::new(&penalized(whole.gram, penalties))?.solve(&whole.moment);
    Some(solution.iter().copied().collect())
}

/// The same, and the mean leverage of the rows `judged`: the mean variance of their prediction over that of one row.
pub fn solve_with_leverage<C: Borrow<[f64]>>(
    columns: &[C],
    penalties: &[f64],
    y: &[f64],
    judged: &[C],
) -> Option<(Vec<f64>, f64)> {
    let fitted = normal(columns, y, 0..y.len());
    let cover = inverse(&penalized(fitted.gram, penalties))?;
    let rows = judged.first().map_or(0, |c| c.borrow().len());
    let leverage = (&cover * gram(judged, 0..rows)).trace() / rows.max(1) as f64;
    Some(((cover * fitted.moment).iter().copied().collect(), leverage))
}

/// Fits `y` by `columns` and cross-validates over groups of contiguous blocks; a block on either side of a
/// held-out group is a guard and is not used for its fit. None when the columns are dependent.
///
/// The acceleration has errors of its own [thesis, eq. 3.9], [fuller-1987]: their square is taken off its normal equation.
/// And a hypothesis is not paid for leaving the noisy regressor out: on a sine a spring-like term can stand in for
/// the mass, and the residual loses the mass times the acceleration's noise without a gain in truth. So the held-out
/// error is charged with the noise of [`Blocks::mass`], whatever mass the hypothesis itself ends with.
pub fn fit<C: Borrow<[f64]>>(columns: &[C], y: &[f64], blocks: &Blocks, folds: usize) -> Option<Fit> {
    Normals::of(columns, y, blocks)?.fit(columns, &[], y, blocks, folds)
}

impl Normals {
    /// Normal equations of `columns`; None where there are too few blocks to leave some out.
    pub fn of<C: Borrow<[f64]>>(columns: &[C], y: &[f64], blocks: &Blocks) -> Option<Arc<Self>> {
        let (p, k) = (columns.len(), blocks.len());
        if p == 0 || k < 4 {
            return None;
        }
        let mut normals: Vec<Normal> = (0..k).map(|b| normal(columns, y, blocks.rows(b))).collect();
        let power: f64 = normals.iter().map(|n| n.gram[(0, 0)]).sum();
        let noise: f64 = (0..k).map(|b| blocks.noise_of(b)).sum();
        // Where noise is most of a regressor no correction can be trusted.
        let corrected = if noise < 0.5 * power { 1.0 } else { 0.0 };
        for (b, n) in normals.iter_mut().enumerate() {
            n.gram[(0, 0)] -= corrected * blocks.noise_of(b);
        }
        let mut gram = DMatrix::zeros(p, p);
        let mut moment = DVector::zeros(p);
        for n in &normals {
            gram += &n.gram;
            moment += &n.moment;
        }
        Some(Arc::new(Self { blocks: normals, gram, moment, corrected }))
    }

    /// [`fit`] of the columns that these are the normal equations of. `penalties` are weights of squared coefficients, in the order
    /// of the columns; where they end, there are none.
    pub fn fit<C: Borrow<[f64]>>(
        self: &Arc<Self>,
        columns: &[C],
        penalties: &[f64],
        y: &[f64],
        blocks: &Blocks,
        folds: usize,
    ) -> Option<Fit> {
        let (p, k) = (columns.len(), blocks.len());
        let Self { blocks: normals, moment, corrected, .. } = &**self;
        let gram = penalized(self.gram.clone(), penalties);
        let factored = Factored::new(&gram)?;
        let solution = factored.solve(moment);
        let mut residual = y.to_vec();
        for (c, column) in solution.iter().zip(columns) {
            subtract_scaled(&mut residual, *c, column.borrow());
        }

        let folds = folds.clamp(2, k);
        let mut heldout = vec![0.0; k];
        let mut heldout_prediction = vec![0.0; y.len()];
        for fold in 0..folds {
            let (low, high) = (fold * k / folds, (fold + 1) * k / folds);
            if low == high {
                continue;
            }
            let guard_low = if low > 0 && !blocks.starts[low] { low - 1 } else { low };
            let guard_high = if high < k && !blocks.starts[high] { high + 1 } else { high };
            let mut g = gram.clone();
            let mut m = moment.clone();
            for n in &normals[guard_low..guard_high] {
                g -= &n.gram;
                m -= &n.moment;
            }
            // What only the fold itself tells of, such as the offset of one recording, is taken to be nothing there.
            let unseen: Vec<usize> = (0..p).filter(|&i| g[(i, i)] <= 1e-9 * gram[(i, i)]).collect();
            for i in unseen {
                g.row_mut(i).fill(0.0);
                g.column_mut(i).fill(0.0);
                g[(i, i)] = gram[(i, i)];
                m[i] = 0.0;
            }
            // A fold without which the fit is not determined is predicted by nothing rather than by itself.
            let beta = Factored::new(&g).map_or_else(|| DVector::zeros(p), |g| g.solve(&m));
            for (b, error) in heldout.iter_mut().enumerate().take(high).skip(low) {
                for row in blocks.rows(b) {
                    let prediction: f64 = beta.iter().zip(columns).map(|(c, x)| c * x.borrow()[row]).sum();
                    heldout_prediction[row] = prediction;
                    *error += (y[row] - prediction).powi(2);
                }
                let mass = beta.get(0).copied().unwrap_or(0.0);
                *error =
                    (*error + corrected * (blocks.mass.powi(2) - mass * mass) * blocks.noise_of(b)).max(0.0);
            }
        }
        let coefficients = solution.iter().copied().collect();
        Some(Fit {
            coefficients,
            std_errors: OnceLock::new(),
            known: Arc::new(Known { normals: self.clone(), gram, factored }),
            residual,
            heldout,
            heldout_prediction,
        })
    }
}

impl Known {
    /// Standard errors by leaving out one block at a time (CR3; MacKinnon, Nielsen and Webb 2023): where a few blocks
    /// hold most of what is known about a coefficient the usual sandwich is too sure of it. Opened by Student's factor for as
    /// many blocks as really speak, so that 1.96 of them hold 95 %.
    fn std_errors(&self) -> Vec<f64> {
        let Self { normals, gram, factored } = self;
        let Normals { blocks: normals, moment, .. } = &**normals;
        let solution = factored.solve(moment);
        let (p, k) = (solution.len(), normals.len() as f64);
        let (mut squares, mut fourths) = (vec![0.0; p], vec![0.0; p]);
        for n in normals {
            let change = match Factored::new(&(gram - &n.gram)) {
                Some(without) => without.solve(&(moment - &n.moment)) - &solution,
                // all that is known of a coefficient is in this block
                None => factored.solve(&(&n.moment - &n.gram * &solution)),
            };
            for (c, (square, fourth)) in change.iter().zip(squares.iter_mut().zip(&mut fourths)) {
                *square += c * c;
                *fourth += c.powi(4);
            }
        }
        let deviation = |(square, fourth): (&f64, &f64)| {
            // as many as would show this kurtosis if each block said as much as any other
            let blocks = (3.0 * square * square / fourth.max(1e-300)).clamp(4.0, k);
            let open =
                StudentsT::new(0.0, 1.0, blocks - 1.0).map_or(1.0, |t| t.inverse_cdf(0.975) / 1.959_964);
            open * (square * (k - 1.0) / k).sqrt()
        };
        squares.iter().zip(&fourths).map(deviation).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_of_the_acceleration_neither_shrinks_the_mass_nor_pays_for_leaving_it_out() {
        use rand::SeedableRng;
        use rand_distr::{Distribution, StandardNormal};
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let truth: Vec<f64> = (0..8000).map(|i| (i as f64 * 0.05).sin()).collect();
        let mut noisy = |level: f64| -> Vec<f64> {
            let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
            truth.iter().map(|a| a + level * draw()).collect()
        };
        let (y, a) = (noisy(0.1), noisy(0.2));
        let spring: Vec<f64> =
            truth.iter().enumerate().map(|(i, a)| a + 0.3 * (i as f64 * 0.031).cos()).collect();
        let edges = (0..=20).map(|i| i * 400).collect();
        let plain = Blocks { edges, starts: vec![false; 20], ..Blocks::default() };
        let blocks = Blocks { noise: vec![0.04 * 400.0; 20], mass: 1.0, ..plain.clone() };
        let shrunk = fit(&[&a[..]], &y, &plain, 10).unwrap();
        let mass = fit(&[&a[..]], &y, &blocks, 10).unwrap();
        println!("plain {:.4}, corrected {:.4}, truth 1", shrunk.coefficients[0], mass.coefficients[0]);
        assert!(shrunk.coefficients[0] < 0.95 && (mass.coefficients[0] - 1.0).abs() < 0.01);
        // a stand-in without noise takes over; only the plain fit believes that it explains something
        let gain = |blocks: &Blocks, without: &Fit| {
            1.0 - fit(&[&a[..], &spring[..]], &y, blocks, 10).unwrap().heldout_sum() / without.heldout_sum()
        };
        let (believed, charged) = (gain(&plain, &shrunk), gain(&blocks, &mass));
        println!("gain of the stand-in: {believed:.3} believed, {charged:.3} charged");
        assert!(believed > 0.1 && charged.abs() < 0.02);
    }

    #[test]
    fn recovers_coefficients_and_leaves_dependent_columns_out() {
        let a: Vec<f64> = (0..400).map(|i| (i as f64 * 0.1).sin()).collect();
        let b: Vec<f64> = (0..400).map(|i| (i as f64 * 0.037).cos()).collect();
        let y: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 2.0 * a - 3.0 * b).collect();
        let blocks = Blocks {
            edges: (0..=20).map(|i| i * 20).collect(),
            starts: vec![false; 20],
            ..Blocks::default()
        };
        let fit = fit(&[&a[..], &b[..]], &y, &blocks, 10).unwrap();
        assert!((fit.coefficients[0] - 2.0).abs() < 1e-9 && (fit.coefficients[1] + 3.0).abs() < 1e-9);
        assert!(fit.heldout_sum() < 1e-12);
        assert!(super::fit(&[&a[..], &vec![0.0; 400][..]], &y, &blocks, 10).is_none());
    }
}
