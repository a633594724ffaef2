//! Inner products of the catalogue's columns with those of a hypothesis. With them, what of an atom lies outside any part of
//! the hypothesis follows without another pass over the rows.

use crate::search::hypothesis::Atom;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use signals::dot;

/// Share of a column's square outside a span below which it counts as inside: what rounding leaves of a difference of
/// squares is far below, what a fit can use is far above.
const INSIDE: f64 = 1e-10;

/// Atoms with their inner products with some fixed columns.
pub struct Overlap<'a> {
    /// The atoms.
    pub atoms: Vec<&'a Atom>,
    /// Of each atom: a row for each of its columns, a column for each fixed one.
    with: Vec<DMatrix<f64>>,
    /// Of each atom: its columns with each other.
    own: Vec<DMatrix<f64>>,
    /// The fixed columns with each other.
    fixed: DMatrix<f64>,
}

/// The span of some of the fixed columns.
pub struct Span {
    inside: Vec<usize>,
    root: Cholesky<f64, Dyn>,
}

impl<'a> Overlap<'a> {
    /// Inner products of `atoms` with the columns `fixed`.
    pub fn new(atoms: Vec<&'a Atom>, fixed: &[&[f64]]) -> Self {
        let products =
            |a: &[&[f64]], b: &[&[f64]]| DMatrix::from_fn(a.len(), b.len(), |i, j| dot(a[i], b[j]));
        let (with, own) = atoms
            .par_iter()
            .map(|atom| {
                let columns: Vec<&[f64]> = atom.columns.iter().map(Vec::as_slice).collect();
                (products(&columns, fixed), products(&columns, &columns))
            })
            .unzip();
        Self { atoms, with, own, fixed: products(fixed, fixed) }
    }

    /// The span of the fixed columns `inside`; None where they are dependent.
    pub fn span(&self, inside: Vec<usize>) -> Option<Span> {
        let root = self.fixed.select_rows(&inside).select_columns(&inside).cholesky()?;
        Some(Span { inside, root })
    }

    /// The gain of atom `i` that fits the sum of the fixed columns times `y` best beside `span`; None where it has several.
    pub fn gain(&self, span: &Span, i: usize, y: &DVector<f64>) -> Option<f64> {
        let (own, with) = (&self.own[i], &self.with[i]);
        if with.nrows() != 1 {
            return None;
        }
        let coordinates = span.coordinates(&with.row(0).transpose());
        let along = span.coordinates(&(&self.fixed * y));
        let moment = with.row(0).transpose().dot(y) - coordinates.dot(&along);
        Some(moment / (own[(0, 0)] - coordinates.norm_squared()))
    }

    /// Squared length of the sum of the fixed columns times `y`, along what of atom `i` is outside `span`.
    pub fn captured(&self, span: &Span, i: usize, y: &DVector<f64>) -> f64 {
        let along = span.coordinates(&(&self.fixed * y));
        let (own, with) = (&self.own[i], &self.with[i]);
        let coordinates: Vec<DVector<f64>> =
            with.row_iter().map(|row| span.coordinates(&row.transpose())).collect();
        let moment = with * y;
        // Cholesky's decomposition column by column, without those that depend on the others
        let mut kept: Vec<(Vec<f64>, f64)> = Vec::new();
        let mut rows: Vec<usize> = Vec::new();
        for k in 0..coordinates.len() {
            let outside = |j: usize| own[(k, j)] - coordinates[k].dot(&coordinates[j]);
            let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
            for (n, (other, _)) in kept.iter().enumerate() {
                let known: f64 = row.iter().zip(other).map(|(a, b)| a * b).sum();
                row.push((outside(rows[n]) - known) / other[n]);
            }
            let left = outside(k) - row.iter().map(|x| x * x).sum::<f64>();
            if !(left > INSIDE * own[(k, k)]) {
                continue;
            }
            let known: f64 = row.iter().zip(&kept).map(|(a, (_, z))| a * z).sum();
            let z = (moment[k] - coordinates[k].dot(&along) - known) / left.sqrt();
            row.push(left.sqrt());
            kept.push((row, z));
            rows.push(k);
        }
        kept.iter().map(|(_, z)| z * z).sum()
    }
}

impl Span {
    /// Coordinates in an orthonormal basis of the span, from inner products with all fixed columns.
    fn coordinates(&self, products: &DVector<f64>) -> DVector<f64> {
        let inside = products.select_rows(&self.inside);
        // the factor is not singular, or there would be no span
        self.root.l_dirty().solve_lower_triangular(&inside).unwrap_or(inside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::term::{Term, TermKind};
    use signals::Basis;

    #[test]
    fn what_inner_products_say_is_what_projections_say() {
        let wave = |hz: f64, slope: f64| -> Vec<f64> {
            (0..900).map(|i| (f64::from(i) * hz).sin() + slope * f64::from(i) / 900.0).collect()
        };
        let fixed = [wave(0.01, 0.0), wave(0.02, 1.0), wave(0.05, -1.0), wave(0.3, 0.2)];
        let kind = TermKind::all()[0];
        let term = Term { kind, shape: [0.0; 2], variant: 0 };
        let mut atom = Atom::of(vec![wave(0.011, 0.5), wave(0.07, 0.0)], &Basis::default(), term);
        // one that says nothing new
        let sum = atom.columns[0].iter().zip(&atom.columns[1]).map(|(a, b)| a - 2.0 * b).collect();
        atom.columns = [atom.columns.to_vec(), vec![sum]].concat().into();
        let fixed: Vec<&[f64]> = fixed.iter().map(Vec::as_slice).collect();
        let overlap = Overlap::new(vec![&atom], &fixed);
        let span = overlap.span(vec![0, 2]).unwrap();
        let y = DVector::from_column_slice(&[0.0, 1.5, 0.0, -0.7]);
        let basis = Basis::of(&[fixed[0], fixed[2]]);
        let sum: Vec<f64> = (0..900).map(|r| 1.5 * fixed[1][r] - 0.7 * fixed[3][r]).collect();
        let rest = basis.project_out(&sum);
        let captured = Basis::of(&atom.outside(&basis)).captured(&rest);
        assert!((overlap.captured(&span, 0, &y) / captured - 1.0).abs() < 1e-7);
    }
}
