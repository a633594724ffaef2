//! Intervals from leaving out one part of a recording at a time.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Parts a recording is left out by, one at a time.
pub(crate) const BLOCKS: usize = 10;
/// Student's t for 95 % and the parts that are left out.
pub(crate) const T95: f64 = 2.262;
const _: () = assert!(BLOCKS == 10);

/// A number and its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// The number.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}

/// Covariance of an estimate from what it is without each part.
pub(crate) fn jackknife(left_out: &[DVector<f64>]) -> DMatrix<f64> {
    let (n, count) = (left_out.first().map_or(0, |x| x.len()), left_out.len() as f64);
    let mean = left_out.iter().fold(DVector::zeros(n), |sum, x| sum + x) / count;
    let squares = left_out.iter().fold(DMatrix::zeros(n, n), |sum, x| {
        let off = x - &mean;
        sum + &off * off.transpose()
    });
    squares * ((count - 1.0) / count)
}

/// A square with what noise adds to it taken off.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Squared {
    pub value: f64,
    pub variance: f64,
}

impl Squared {
    /// d'Wd − tr(WΣ), variance 4·d'WΣWd + 2·tr((WΣ)²).
    pub fn of(off: &DVector<f64>, weight: &DVector<f64>, noise: &DMatrix<f64>) -> Self {
        let weighted = off.component_mul(weight);
        let both = DMatrix::from_diagonal(weight) * noise;
        Self {
            value: off.dot(&weighted) - both.trace(),
            variance: 4.0 * (weighted.transpose() * noise * &weighted)[0] + 2.0 * (&both * &both).trace(),
        }
    }

    pub fn root(self) -> Interval {
        let root = |square: f64| square.max(0.0).sqrt();
        let half = T95 * root(self.variance);
        Interval { value: root(self.value), ci95: [root(self.value - half), root(self.value + half)] }
    }
}
