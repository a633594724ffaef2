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

/// What of a sum of the fixed columns lies outside the span of some of them.
pub struct Span {
    inside: Vec<usize>,
    root: Cholesky<f64, Dyn>,
    /// Coefficients of the sum.
    y: DVector<f64>,
    /// The part of the sum inside the span.
    along: DVector<f64>,
    /// Squared length of the part outside.
    pub power: f64,
}

impl<'a> Overlap<'a> {
    /// Inner products of `atoms` with the columns `fixed`.
    pub fn new(atoms: Vec<&'a Atom>, fixed: &[&[f64]]) -> Self {
        let products =
            |a: &[&[f64]], b: &[&[f64]]| DMatrix::from_fn(a.len(), b.len(), |i, j| dot(a[i], b[j]));
        let (with, own) = atoms
            .par_iter()
            .map(|atom| {
                let columns: Vec<&[f64]> = atom.columns.iter().map(|c| c.as_slice()).collect();
                (products(&columns, fixed), products(&columns, &columns))
            })
            .unzip();
        Self { atoms, with, own, fixed: products(fixed, fixed) }
    }

    /// The sum of the fixed columns times `y`, outside the span of those at `inside`; None where they are dependent.
    pub fn span(&self, inside: Vec<usize>, y: DVector<f64>) -> Option<Span> {
        let root = self.fixed.select_rows(&inside).select_columns(&inside).cholesky()?;
        let products = &self.fixed * &y;
        let mut span = Span { inside, root, power: 0.0, along: DVector::zeros(0), y };
        span.along = span.coordinates(&products);
        span.power = span.y.dot(&products) - span.along.norm_squared();
        Some(span)
    }

    /// What of atom `i` lies outside `span`.
    pub fn outside(&self, span: &Span, i: usize) -> Outside {
        let with = &self.with[i];
        let coordinates: Vec<DVector<f64>> =
            with.row_iter().map(|row| span.coordinates(&row.transpose())).collect();
        let own = DMatrix::from_fn(with.nrows(), with.nrows(), |j, k| {
            self.own[i][(j, k)] - coordinates[j].dot(&coordinates[k])
        });
        let moment = with * &span.y;
        let moment = DVector::from_fn(with.nrows(), |k, _| moment[k] - coordinates[k].dot(&span.along));
        Outside { coordinates, own, moment, whole: self.own[i].diagonal() }
    }

    /// Squared length of the sum along what of atom `i` is outside `span`.
    pub fn captured(&self, span: &Span, i: usize) -> f64 {
        self.outside(span, i).captured()
    }

    /// The same along what of several atoms is outside `span`.
    pub fn pairs<'b>(&'b self, span: &'b Span, of: &'b [usize]) -> Pairs<'b> {
        Pairs { overlap: self, of, alone: of.iter().map(|i| self.outside(span, *i)).collect() }
    }
}

/// What of an atom's columns lies outside a span.
pub struct Outside {
    /// Of each column: coordinates of the rest, in the span.
    coordinates: Vec<DVector<f64>>,
    /// Inner products with each other.
    own: DMatrix<f64>,
    /// Inner products with the sum outside the span.
    moment: DVector<f64>,
    /// Squares of the whole columns.
    whole: DVector<f64>,
}

impl Outside {
    /// The gain of the atom that fits the sum best beside the span; None where it has several.
    pub fn gain(&self) -> Option<f64> {
        (self.moment.len() == 1).then(|| self.moment[0] / self.own[(0, 0)])
    }

    /// Squared length of the sum along these.
    pub fn captured(&self) -> f64 {
        captured(&self.own, &self.moment, &self.whole)
    }
}

/// Some atoms of an overlap, to be looked at two at a time.
pub struct Pairs<'a> {
    overlap: &'a Overlap<'a>,
    of: &'a [usize],
    alone: Vec<Outside>,
}

impl Pairs<'_> {
    /// Squared length of the sum along what of the `i`th and the `j`th is outside the span.
    pub fn captured(&self, i: usize, j: usize) -> f64 {
        let (one, other) = (&self.alone[i], &self.alone[j]);
        let (n, m) = (one.moment.len(), other.moment.len());
        let columns = |i: usize| &self.overlap.atoms[self.of[i]].columns;
        let (columns_i, columns_j) = (columns(i), columns(j));
        let across = DMatrix::from_fn(n, m, |k, l| {
            dot(&columns_i[k], &columns_j[l]) - one.coordinates[k].dot(&other.coordinates[l])
        });
        let own = DMatrix::from_fn(n + m, n + m, |k, l| match (k < n, l < n) {
            (true, true) => one.own[(k, l)],
            (true, false) => across[(k, l - n)],
            (false, true) => across[(l, k - n)],
            (false, false) => other.own[(k - n, l - n)],
        });
        let both = |x: &DVector<f64>, y: &DVector<f64>| {
            DVector::from_fn(n + m, |k, _| if k < n { x[k] } else { y[k - n] })
        };
        captured(&own, &both(&one.moment, &other.moment), &both(&one.whole, &other.whole))
    }
}

/// Squared length along columns with inner products `own` among each other and `moment` with what is captured; `whole` are their
/// squares before anything was taken out of them.
fn captured(own: &DMatrix<f64>, moment: &DVector<f64>, whole: &DVector<f64>) -> f64 {
    // Cholesky's decomposition column by column, without those that depend on the others
    let mut kept: Vec<(Vec<f64>, f64)> = Vec::new();
    let mut rows: Vec<usize> = Vec::new();
    for k in 0..moment.len() {
        let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
        for (n, (other, _)) in kept.iter().enumerate() {
            let known: f64 = row.iter().zip(other).map(|(a, b)| a * b).sum();
            row.push((own[(k, rows[n])] - known) / other[n]);
        }
        let left = own[(k, k)] - row.iter().map(|x| x * x).sum::<f64>();
        if !(left > INSIDE * whole[k]) {
            continue;
        }
        let known: f64 = row.iter().zip(&kept).map(|(a, (_, z))| a * z).sum();
        let z = (moment[k] - known) / left.sqrt();
        row.push(left.sqrt());
        kept.push((row, z));
        rows.push(k);
    }
    kept.iter().map(|(_, z)| z * z).sum()
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
    use std::sync::Arc;

    #[test]
    fn what_inner_products_say_is_what_projections_say() {
        let wave = |hz: f64, slope: f64| -> Vec<f64> {
            (0..900).map(|i| (f64::from(i) * hz).sin() + slope * f64::from(i) / 900.0).collect()
        };
        let fixed = [wave(0.01, 0.0), wave(0.02, 1.0), wave(0.05, -1.0), wave(0.3, 0.2)];
        let kind = TermKind::all()[0];
        let term = Term { kind, shape: [0.0; 2], variant: 0 };
        let columns = [wave(0.011, 0.5), wave(0.07, 0.0)].map(Arc::new);
        let mut atom = Atom::of(columns, &Basis::default(), |_| 0.0, term);
        // one that says nothing new
        let sum = atom.columns[0].iter().zip(atom.columns[1].iter()).map(|(a, b)| a - 2.0 * b).collect();
        atom.columns = [atom.columns.to_vec(), vec![Arc::new(sum)]].concat().into();
        let fixed: Vec<&[f64]> = fixed.iter().map(Vec::as_slice).collect();
        let overlap = Overlap::new(vec![&atom], &fixed);
        let span = overlap.span(vec![0, 2], DVector::from_column_slice(&[0.0, 1.5, 0.0, -0.7])).unwrap();
        let basis = Basis::of(&[fixed[0], fixed[2]]);
        let sum: Vec<f64> = (0..900).map(|r| 1.5 * fixed[1][r] - 0.7 * fixed[3][r]).collect();
        let rest = basis.project_out(&sum);
        let captured = Basis::of(&atom.outside(&basis)).captured(&rest);
        assert!((overlap.captured(&span, 0) / captured - 1.0).abs() < 1e-7);
        assert!((span.power / dot(&rest, &rest) - 1.0).abs() < 1e-7);
        let other = Atom::of([Arc::new(wave(0.021, -0.5))], &Basis::default(), |_| 0.0, term);
        let overlap = Overlap::new(vec![&atom, &other], &fixed);
        let both = [atom.outside(&basis), other.outside(&basis)].concat();
        let pair = overlap.pairs(&span, &[1, 0]).captured(1, 0);
        assert!((pair / Basis::of(&both).captured(&rest) - 1.0).abs() < 1e-7);
    }
}
