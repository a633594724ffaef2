//! Linear regression with errors in the regressors and autocorrelated residuals.
//!
//! Least squares by QR of scaled columns [thesis, eq. 3.8], or Fuller's estimator [thesis, eq. 3.9] where the error variances of
//! the regressors are known. Covariance: sandwich with Bartlett weights (Newey, West 1987), bandwidth from the
//! data (Andrews 1991), on the score x_t e_t + S β, whose mean is zero where that of x_t e_t is not.

use nalgebra::{DMatrix, DVector};

/// A column whose part orthogonal to the others is smaller than this share of itself is one of them in disguise.
const COLLINEAR: f64 = 1e-7;

/// Squared size of a column below which it is not there.
const VANISHED: f64 = 1e-200;

/// Least share of a column's own variance that must be motion and not measurement error.
const RELIABLE: f64 = 0.2;

/// Why a column has no coefficient.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Dropped {
    /// It is zero throughout.
    Absent,
    /// It is a combination of these others.
    Collinear(Vec<usize>),
    /// This share of what is its own is measurement error.
    Noise(f64),
}

/// A regression problem: rows are samples that are fitted.
pub(crate) struct Problem<'a> {
    /// Regressors, one vector each.
    pub columns: &'a [Vec<f64>],
    /// What they explain.
    pub target: &'a [f64],
    /// Index in the recording of each row, rising: rows that are not neighbours in time are not neighbours here.
    pub at: &'a [usize],
    /// S of [thesis, eq. 3.9]: error variance of each regressor over all rows. Zero for least squares.
    pub errors: &'a [f64],
}

/// The answer. Dropped columns have coefficient 0 and no covariance.
#[derive(Debug, Clone)]
pub(crate) struct Solution {
    pub coefficients: Vec<f64>,
    /// Covariance of the coefficients, all columns.
    pub covariance: DMatrix<f64>,
    /// The same as if errors were independent and regressors exact.
    pub white: DMatrix<f64>,
    pub residual: Vec<f64>,
    pub dropped: Vec<(usize, Dropped)>,
    pub effective_samples: f64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Singular directions of the scaled columns `kept`: None when they are independent, else the columns that
/// take part in the weakest direction.
fn collinear(columns: &[Vec<f64>], kept: &[usize]) -> Option<Vec<usize>> {
    if kept.is_empty() {
        return None;
    }
    let scaled = scaled(columns, kept);
    let svd = scaled.qr().r().svd(false, true);
    let (weakest, value) =
        svd.singular_values.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
    if value > COLLINEAR {
        return None;
    }
    let direction = svd.v_t?.row(weakest).transpose();
    let largest = direction.amax();
    Some(
        kept.iter()
            .zip(direction.iter())
            .filter(|(_, d)| d.abs() > 1e-3 * largest)
            .map(|(k, _)| *k)
            .collect(),
    )
}

fn scaled(columns: &[Vec<f64>], kept: &[usize]) -> DMatrix<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    let norms: Vec<f64> = kept.iter().map(|k| dot(&columns[*k], &columns[*k]).sqrt()).collect();
    DMatrix::from_fn(rows, kept.len(), |i, j| columns[kept[j]][i] / norms[j])
}

impl Problem<'_> {
    /// Solves it. None without enough finite rows for the independent columns.
    pub fn solve(&self) -> Option<Solution> {
        let rows = self.target.len();
        let finite = self.target.iter().chain(self.columns.iter().flatten()).all(|x| x.is_finite());
        if rows == 0 || !finite {
            return None;
        }
        let mut dropped = Vec::new();
        let mut kept: Vec<usize> = Vec::new();
        for (k, column) in self.columns.iter().enumerate() {
            let size = dot(column, column);
            if !size.is_finite() {
                return None;
            }
            // A square that underflows cannot be scaled by.
            if size > VANISHED {
                kept.push(k);
            } else {
                dropped.push((k, Dropped::Absent));
            }
        }
        while let Some(group) = collinear(self.columns, &kept) {
            for k in &group {
                let others = group.iter().copied().filter(|o| o != k).collect();
                dropped.push((*k, Dropped::Collinear(others)));
            }
            // The combination still has to be fitted, or it would be blamed on the columns that are left: keep
            // the largest part of it, unreported.
            let carrier = group.iter().copied().max_by(|a, b| {
                let size = |k: &usize| {
                    dot(&self.columns[*k], self.target).abs()
                        / dot(&self.columns[*k], &self.columns[*k]).sqrt()
                };
                size(a).total_cmp(&size(b))
            });
            kept.retain(|k| !group.contains(k) || Some(*k) == carrier);
            if group.len() < 2 {
                break;
            }
        }
        loop {
            if kept.is_empty() || rows <= kept.len() + 2 {
                return None;
            }
            let q = scaled(self.columns, &kept);
            let inverse = q.tr_mul(&q).cholesky()?.inverse();
            // Share of each column's own variance (1/VIF of it) that is measurement error.
            let worst = kept
                .iter()
                .enumerate()
                .map(|(j, k)| {
                    let own = dot(&self.columns[*k], &self.columns[*k]) / inverse[(j, j)];
                    (*k, self.errors[*k] * rows as f64 / own)
                })
                .filter(|(_, share)| *share > 1.0 - RELIABLE)
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((k, share)) = worst else { break };
            kept.retain(|o| *o != k);
            for other in self.stands_for(k, &kept) {
                if !dropped.iter().any(|(d, _)| *d == other) {
                    dropped.push((other, Dropped::Collinear(vec![k])));
                }
            }
            if !dropped.iter().any(|(d, _)| *d == k) {
                dropped.push((k, Dropped::Noise(share.min(1.0))));
            }
        }
        self.estimate(&kept, dropped)
    }

    /// Columns that take over what column `k`, left out, would have explained: those that make it up but for its
    /// noise. Their coefficients are then sums, not their own.
    fn stands_for(&self, k: usize, kept: &[usize]) -> Vec<usize> {
        let column = &self.columns[k];
        let size = dot(column, column);
        let x = scaled(self.columns, kept);
        let y = DVector::from_column_slice(column);
        let Some(loads) = x.tr_mul(&x).cholesky().map(|c| c.solve(&x.tr_mul(&y))) else { return Vec::new() };
        if (&x * &loads).norm_squared() < 0.5 * size {
            return Vec::new();
        }
        kept.iter()
            .zip(loads.iter())
            .filter(|(_, load)| *load * *load > 0.05 * size)
            .map(|(k, _)| *k)
            .collect()
    }

    fn estimate(&self, kept: &[usize], mut dropped: Vec<(usize, Dropped)>) -> Option<Solution> {
        let (rows, count) = (self.target.len(), self.columns.len());
        let n = rows as f64;
        let norms: Vec<f64> =
            kept.iter().map(|k| (dot(&self.columns[*k], &self.columns[*k]) / n).sqrt()).collect();
        let x = scaled(self.columns, kept) * n.sqrt();
        let y = DVector::from_column_slice(self.target);
        // Everything below in columns of unit mean square.
        let error = DVector::from_iterator(
            kept.len(),
            kept.iter().zip(&norms).map(|(k, s)| self.errors[*k] / (s * s)),
        );
        let qr = x.clone().qr();
        let moment = x.tr_mul(&x) / n - DMatrix::from_diagonal(&error);
        let exact = error.iter().all(|e| *e == 0.0);
        let beta = if exact {
            qr.r().solve_upper_triangular(&qr.q().tr_mul(&y))?
        } else {
            moment.clone().cholesky()?.solve(&(x.tr_mul(&y) / n))
        };
        let residual = &y - &x * &beta;
        let own = error.component_mul(&beta);
        let scores: Vec<DVector<f64>> =
            (0..rows).map(|i| x.row(i).transpose() * residual[i] + &own).collect();
        let bandwidth = bandwidth(&scores, self.at);
        // A Bartlett window of so many lags leaves this many degrees of freedom, of which the coefficients take theirs.
        let degrees = if bandwidth > 0 { (1.5 * n / bandwidth as f64).min(n) } else { n };
        let freedom = degrees / (degrees - kept.len() as f64).max(0.5 * degrees);
        let middle = long_run(&scores, self.at, bandwidth) * (freedom / n);
        let inverse = moment.try_inverse()?;
        let sandwich = &inverse * middle * &inverse;
        let white = (x.tr_mul(&x)).try_inverse()? * (residual.norm_squared() / (n - kept.len() as f64));
        let residual: Vec<f64> = residual.iter().copied().collect();
        let singles: Vec<DVector<f64>> = residual.iter().map(|e| DVector::from_element(1, *e)).collect();
        let power = dot(&residual, &residual) / n;
        let long = long_run(&singles, self.at, bandwidth)[(0, 0)];
        let mut out = Solution {
            coefficients: vec![0.0; count],
            covariance: DMatrix::zeros(count, count),
            white: DMatrix::zeros(count, count),
            residual,
            dropped: Vec::new(),
            effective_samples: if long > power && power > 0.0 { n * power / long } else { n },
        };
        for (j, k) in kept.iter().enumerate() {
            out.coefficients[*k] = beta[j] / norms[j];
            for (i, o) in kept.iter().enumerate() {
                out.covariance[(*k, *o)] = sandwich[(j, i)] / (norms[j] * norms[i]);
                out.white[(*k, *o)] = white[(j, i)] / (norms[j] * norms[i]);
            }
        }
        dropped.sort_by_key(|(k, _)| *k);
        out.dropped = dropped;
        Some(out)
    }
}

/// Independent values per value of a residual at the rows `at`, at most 1.
pub(crate) fn independence(residual: &[f64], at: &[usize]) -> f64 {
    let singles: Vec<DVector<f64>> = residual.iter().map(|e| DVector::from_element(1, *e)).collect();
    let power = dot(residual, residual) / residual.len().max(1) as f64;
    let long = long_run(&singles, at, bandwidth(&singles, at))[(0, 0)];
    if long > power && power > 0.0 { power / long } else { 1.0 }
}

/// Andrews' bandwidth for Bartlett weights, from first-order autoregressions of the scores.
fn bandwidth(scores: &[DVector<f64>], at: &[usize]) -> usize {
    let n = scores.len() as f64;
    let width = scores.first().map_or(0, DVector::len);
    let (mut top, mut bottom) = (0.0, 0.0);
    for j in 0..width {
        let power: f64 = scores.iter().map(|s| s[j] * s[j]).sum();
        let next: f64 = neighbours(at, 1).map(|(a, b)| scores[a][j] * scores[b][j]).sum();
        if power <= 0.0 {
            continue;
        }
        let rho = (next / power).clamp(-0.97, 0.97);
        // the scores are scaled: variances weigh the columns by what they are worth
        let variance = power / n * (1.0 - rho * rho);
        top += 4.0 * (rho * variance).powi(2) / ((1.0 - rho).powi(6) * (1.0 + rho).powi(2));
        bottom += variance.powi(2) / (1.0 - rho).powi(4);
    }
    if bottom <= 0.0 {
        return 0;
    }
    let optimal = 1.1447 * (top / bottom * n).cbrt();
    // floor: white scores have a small positive rho half of the time, which is worth no lag
    (optimal.floor().min(0.2 * n)) as usize
}

/// Pairs of rows that are `lag` samples apart.
fn neighbours(at: &[usize], lag: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
    let mut late = 0;
    (0..at.len()).filter_map(move |early| {
        while late < at.len() && at[late] < at[early] + lag {
            late += 1;
        }
        (late < at.len() && at[late] == at[early] + lag).then_some((early, late))
    })
}

/// Variance of the mean of the scores times their number, excluded rows counting as zero.
fn long_run(scores: &[DVector<f64>], at: &[usize], bandwidth: usize) -> DMatrix<f64> {
    let n = scores.len() as f64;
    let width = scores.first().map_or(0, DVector::len);
    let mut sum = DMatrix::zeros(width, width);
    for s in scores {
        sum.ger(1.0, s, s, 1.0);
    }
    for lag in 1..=bandwidth {
        let weight = 1.0 - lag as f64 / (bandwidth + 1) as f64;
        let mut cross = DMatrix::zeros(width, width);
        for (a, b) in neighbours(at, lag) {
            cross.ger(1.0, &scores[a], &scores[b], 1.0);
        }
        sum += (&cross + cross.transpose()) * weight;
    }
    sum / n
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn normal(seed: u64, n: usize) -> Vec<f64> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        (0..n).map(|_| StandardNormal.sample(&mut random)).collect()
    }

    #[test]
    fn a_line_is_found_exactly() {
        let columns = vec![vec![1.0; 6], (0..6).map(f64::from).collect::<Vec<_>>()];
        let target: Vec<f64> = (0..6).map(|i| 3.0 - 2.0 * f64::from(i)).collect();
        let at: Vec<usize> = (0..6).collect();
        let s = Problem { columns: &columns, target: &target, at: &at, errors: &[0.0, 0.0] }.solve().unwrap();
        assert!((s.coefficients[0] - 3.0).abs() < 1e-12 && (s.coefficients[1] + 2.0).abs() < 1e-12);
        assert!(s.dropped.is_empty());
    }

    #[test]
    fn a_copy_of_a_column_is_named_and_the_rest_still_fitted() {
        let a = normal(1, 200);
        let b = normal(2, 200);
        let twice: Vec<f64> = a.iter().map(|x| 2.0 * x).collect();
        let target: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + 5.0 * b).collect();
        let at: Vec<usize> = (0..200).collect();
        let columns = vec![a, twice, b];
        let s = Problem { columns: &columns, target: &target, at: &at, errors: &[0.0; 3] }.solve().unwrap();
        assert_eq!(s.dropped, [(0, Dropped::Collinear(vec![1])), (1, Dropped::Collinear(vec![0]))]);
        assert!((s.coefficients[2] - 5.0).abs() < 1e-10);
    }

    #[test]
    fn deviations_tell_the_spread_when_residuals_follow_each_other() {
        // AR(1) errors with rho 0.9 on a slow regressor: the textbook formula is four times too small
        let n = 2000;
        let x: Vec<f64> = (0..n).map(|i| (i as f64 * 0.01).sin()).collect();
        let at: Vec<usize> = (0..n).collect();
        let columns = vec![x.clone()];
        let (mut found, mut reported, mut textbook) = (Vec::new(), 0.0, 0.0);
        for seed in 0..200 {
            let mut e = 0.0;
            let target: Vec<f64> = normal(seed, n)
                .iter()
                .zip(&x)
                .map(|(w, x)| {
                    e = 0.9 * e + w;
                    2.0 * x + e
                })
                .collect();
            let s = Problem { columns: &columns, target: &target, at: &at, errors: &[0.0] }.solve().unwrap();
            found.push(s.coefficients[0]);
            reported += s.covariance[(0, 0)].sqrt() / 200.0;
            textbook += s.white[(0, 0)].sqrt() / 200.0;
        }
        let mean = found.iter().sum::<f64>() / 200.0;
        let spread = (found.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / 199.0).sqrt();
        println!("spread {spread:.4}, reported {reported:.4}, textbook {textbook:.4}");
        assert!((reported / spread - 1.0).abs() < 0.2 && textbook < 0.4 * spread);
    }

    #[test]
    fn errors_in_a_regressor_are_corrected() {
        let n = 4000;
        let truth = normal(7, n);
        let at: Vec<usize> = (0..n).collect();
        let (mut plain, mut fuller) = (0.0, 0.0);
        for seed in 0..20 {
            let x: Vec<f64> = truth.iter().zip(normal(100 + seed, n)).map(|(t, u)| t + 0.5 * u).collect();
            let y: Vec<f64> =
                truth.iter().zip(normal(200 + seed, n)).map(|(t, u)| 2.0 * t + 0.1 * u).collect();
            let columns = vec![x];
            let solve =
                |s: f64| Problem { columns: &columns, target: &y, at: &at, errors: &[s] }.solve().unwrap();
            plain += solve(0.0).coefficients[0] / 20.0;
            fuller += solve(0.25).coefficients[0] / 20.0;
        }
        println!("truth 2, least squares {plain:.4}, Fuller {fuller:.4}");
        assert!((plain - 1.6).abs() < 0.02 && (fuller - 2.0).abs() < 0.02);
    }

    #[test]
    fn columns_whose_squares_underflow_or_overflow_are_no_columns() {
        let at: Vec<usize> = (0..50).collect();
        let target = vec![1.0; 50];
        for size in [1e-170, 1e-300, 1e200, f64::NAN, f64::INFINITY] {
            let columns = vec![vec![1.0; 50], normal(1, 50).iter().map(|x| size * x).collect()];
            let problem = Problem { columns: &columns, target: &target, at: &at, errors: &[0.0, 0.0] };
            match problem.solve() {
                Some(s) => assert_eq!(s.dropped, [(1, Dropped::Absent)]),
                None => assert!(!(size < 1e100)),
            }
        }
    }

    #[test]
    fn a_regressor_that_is_all_noise_is_dropped() {
        let n = 1000;
        let columns = vec![normal(1, n), vec![1.0; n]];
        let at: Vec<usize> = (0..n).collect();
        let s = Problem { columns: &columns, target: &vec![2.0; n], at: &at, errors: &[0.95, 0.0] }
            .solve()
            .unwrap();
        assert!(matches!(s.dropped[..], [(0, Dropped::Noise(_))]));
        assert!((s.coefficients[1] - 2.0).abs() < 1e-12);
    }
}
