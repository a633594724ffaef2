//! Linear algebra over columns of many rows: inner products, orthonormal bases, random signs of blocks.

use pulp::Arch;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::borrow::Borrow;

/// Inner product, in eight partial sums: one running sum would have to wait for itself at every term. The same bits on
/// every processor: the widest registers it has are used, nothing is fused.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let ((a, rest_a), (b, rest_b)) = (a[..n].as_chunks::<8>(), b[..n].as_chunks::<8>());
    let sums = Arch::new().dispatch(
        #[inline(always)]
        || {
            let mut sums = [0.0; 8];
            for (a, b) in a.iter().zip(b) {
                for ((s, x), y) in sums.iter_mut().zip(a).zip(b) {
                    *s += x * y;
                }
            }
            sums
        },
    );
    sums.iter().sum::<f64>() + rest_a.iter().zip(rest_b).map(|(x, y)| x * y).sum::<f64>()
}

/// Subtracts `times` a column from another.
pub fn subtract_scaled(from: &mut [f64], times: f64, column: &[f64]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (x, q) in from.iter_mut().zip(column) {
                *x -= times * q;
            }
        },
    );
}

/// Columns of a basis that are projected on together: the column they are taken out of is read once for all.
const TOGETHER: usize = 4;

/// [`dot`] of several columns with one.
fn dots(columns: [&[f64]; TOGETHER], with: &[f64]) -> [f64; TOGETHER] {
    // a browser keeps the sums of one column in registers, not those of four: half the time, the same bits
    if cfg!(target_arch = "wasm32") {
        return columns.map(|column| dot(column, with));
    }
    Arch::new().dispatch(
        #[inline(always)]
        || sums_of(columns, with),
    )
}

/// Inner products of `L` columns with one, each in eight partial sums.
#[inline(always)]
fn sums_of<const L: usize>(columns: [&[f64]; L], with: &[f64]) -> [f64; L] {
    let n = columns.iter().map(|c| c.len()).fold(with.len(), usize::min);
    let columns = columns.map(|c| c[..n].as_chunks::<8>());
    let (with, rest) = with[..n].as_chunks::<8>();
    let mut sums = [[0.0; 8]; L];
    for (k, x) in with.iter().enumerate() {
        for (sum, (column, _)) in sums.iter_mut().zip(&columns) {
            for ((s, q), x) in sum.iter_mut().zip(&column[k]).zip(x) {
                *s += q * x;
            }
        }
    }
    std::array::from_fn(|i| {
        sums[i].iter().sum::<f64>() + columns[i].1.iter().zip(rest).map(|(q, x)| q * x).sum::<f64>()
    })
}

/// Inner products of a column with each of `others` over the rows between neighbouring `edges`: all those of the first block
/// of rows, then those of the next.
#[must_use]
pub fn block_products(column: &[f64], others: &[&[f64]], edges: &[usize]) -> Vec<f64> {
    let mut out = Vec::with_capacity(others.len() * edges.len().saturating_sub(1));
    Arch::new().dispatch(
        #[inline(always)]
        move || {
            for rows in edges.windows(2).map(|edge| edge[0]..edge[1]) {
                let with = &column[rows.clone()];
                let (groups, rest) = others.as_chunks::<TOGETHER>();
                for group in groups {
                    out.extend(sums_of(group.map(|c| &c[rows.clone()]), with));
                }
                for c in rest {
                    out.extend(sums_of([&c[rows.clone()]], with));
                }
            }
            out
        },
    )
}

/// [`subtract_scaled`] of several columns from one.
fn subtract_all(from: &mut [f64], times: [f64; TOGETHER], columns: [&[f64]; TOGETHER]) {
    let [a, b, c, d] = columns;
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for ((((x, a), b), c), d) in from.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                *x -= (times[0] * a + times[1] * b) + (times[2] * c + times[3] * d);
            }
        },
    );
}

/// An orthonormal basis of the columns pushed so far.
#[derive(Debug, Clone, Default)]
pub struct Basis {
    columns: Vec<Vec<f64>>,
}

impl Basis {
    /// A basis of `columns`; those that depend on earlier ones are left out.
    #[must_use]
    pub fn of<C: Borrow<[f64]>>(columns: &[C]) -> Self {
        let mut basis = Self::default();
        for column in columns {
            basis.push(column.borrow());
        }
        basis
    }

    /// The directions, each of unit length.
    #[must_use]
    pub fn columns(&self) -> &[Vec<f64>] {
        &self.columns
    }

    /// Adds the direction of `column`; false when it is already in the span.
    pub fn push(&mut self, column: &[f64]) -> bool {
        let size = dot(column, column).sqrt();
        let mut rest = self.project_out(column);
        let left = dot(&rest, &rest).sqrt();
        if !left.is_finite() || left <= 1e-7 * size || left == 0.0 {
            return false;
        }
        for x in &mut rest {
            *x /= left;
        }
        self.columns.push(rest);
        true
    }

    /// What is left of `column` outside the span; projected again where rounding could show.
    #[must_use]
    pub fn project_out(&self, column: &[f64]) -> Vec<f64> {
        let mut rest = column.to_vec();
        let mut size = dot(&rest, &rest);
        for _ in 0..3 {
            let (groups, others) = self.columns.as_chunks::<TOGETHER>();
            for group in groups {
                let group = group.each_ref().map(Vec::as_slice);
                let along = dots(group, &rest);
                subtract_all(&mut rest, along, group);
            }
            for q in others {
                let along = dot(q, &rest);
                subtract_scaled(&mut rest, along, q);
            }
            let left = dot(&rest, &rest);
            if left > 0.01 * size {
                break;
            }
            size = left;
        }
        rest
    }

    /// Squared length of the part of `column` outside the span.
    #[must_use]
    pub fn left(&self, column: &[f64]) -> f64 {
        let whole = dot(column, column);
        let left = whole - self.captured(column);
        // a difference of nearly equal squares says nothing
        if left > 0.01 * whole {
            return left;
        }
        let rest = self.project_out(column);
        dot(&rest, &rest)
    }

    /// Squared length of the part of `column` inside the span.
    #[must_use]
    pub fn captured(&self, column: &[f64]) -> f64 {
        let (groups, others) = self.columns.as_chunks::<TOGETHER>();
        let along = groups.iter().flat_map(|group| dots(group.each_ref().map(Vec::as_slice), column));
        along.chain(others.iter().map(|q| dot(q, column))).map(|x| x * x).sum()
    }
}

/// Draws of a random sign for every block.
#[must_use]
pub fn random_signs(draws: usize, blocks: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut sign = || if random.random::<bool>() { 1.0 } else { -1.0 };
    (0..draws).map(|_| (0..blocks).map(|_| sign()).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_by_block_are_those_of_the_rows() {
        let wave = |w: f64| (0..203).map(|i| (f64::from(i) * w).sin()).collect::<Vec<f64>>();
        let columns = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6].map(wave);
        let others: Vec<&[f64]> = columns[1..].iter().map(Vec::as_slice).collect();
        let products = block_products(&columns[0], &others, &[0, 7, 100, 203]);
        let rows = [0..7, 7..100, 100..203];
        let expected =
            rows.iter().flat_map(|r| others.iter().map(|c| dot(&columns[0][r.clone()], &c[r.clone()])));
        assert!(products.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12) && products.len() == 15);
        let basis = Basis::of(&others);
        let rest = basis.project_out(&columns[0]);
        assert!((basis.left(&columns[0]) / dot(&rest, &rest) - 1.0).abs() < 1e-9);
        let inside: Vec<f64> = columns[1].iter().zip(&columns[2]).map(|(a, b)| a - b).collect();
        assert!(basis.left(&inside) < 1e-24 * dot(&inside, &inside));
    }

    #[test]
    fn dependent_columns_add_no_direction() {
        let a: Vec<f64> = (0..400).map(|i| f64::from(i % 17) - 8.0).collect();
        let b: Vec<f64> = (0..400).map(|i| (f64::from(i) * 0.037).cos()).collect();
        let y: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 2.0 * a - 3.0 * b).collect();
        let mut basis = Basis::of(&[&a[..], &b[..]]);
        assert!(!basis.push(&y));
        assert!((basis.captured(&y) / dot(&y, &y) - 1.0).abs() < 1e-12);
        let rest = basis.project_out(&y);
        assert!(dot(&rest, &rest) < 1e-20 * dot(&y, &y));
    }
}
