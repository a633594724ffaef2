//! The baseline with some effects beside it, fitted jointly.

use crate::free_form::term::FreeTerm;
use crate::library::design_matrix::DesignMatrix;
use crate::library::kept::Column;
use crate::library::term::{Term, TermKind};
use crate::regression::linear::{FOLDS, Fit, fit};
use signals::{Basis, dot};
use std::sync::Arc;

/// A term with its columns on the design matrix.
#[derive(Debug, Clone)]
pub struct Atom {
    /// The hypothesis.
    pub term: Term,
    /// Columns that the baseline does not already contain.
    pub columns: Arc<[Column]>,
    /// Which of the term's free gains they are.
    pub active: Vec<usize>,
    /// Share of the columns left outside the baseline, 0 = concealed on this motion.
    pub visible: f64,
    /// Share of what is left that is signal rather than sensor noise.
    pub reliable: f64,
}

impl Atom {
    /// Evaluates a term; `baseline` is a basis of the baseline's columns.
    pub fn new(design: &DesignMatrix, baseline: &Basis, term: Term) -> Self {
        Self::of(design.kept_columns(&term).iter().cloned(), baseline, |c| design.noise_beside(c), term)
    }

    /// The same from columns that are already there; `noise` is what noise of the baseline leaves of the square of a column.
    pub fn of(
        all: impl IntoIterator<Item = Column>,
        baseline: &Basis,
        noise: impl Fn(&[f64]) -> f64,
        term: Term,
    ) -> Self {
        let mut columns = Vec::new();
        let mut active = Vec::new();
        let mut visible: f64 = 0.0;
        for (i, column) in all.into_iter().enumerate() {
            let level = if term.kind.about().has_reference {
                column.iter().sum::<f64>().powi(2) / column.len().max(1) as f64
            } else {
                0.0
            };
            let size = (dot(&column, &column) - level).max(0.0).sqrt();
            let left = baseline.left(&column).sqrt();
            if size > 0.0 && size.is_finite() && left.is_finite() {
                let without_noise = (left * left - noise(&column)).max(0.0).sqrt();
                visible = visible.max(without_noise / size);
                if left > 1e-3 * size {
                    columns.push(column);
                    active.push(i);
                }
            }
        }
        Self { term, columns: columns.into(), active, visible, reliable: 1.0 }
    }

    /// The same on a design matrix on which another force acts.
    pub fn again(&self, design: &DesignMatrix, baseline: &Basis) -> Self {
        Self { reliable: self.reliable, ..Self::new(design, baseline, self.term) }
    }

    /// Numbers that it is fitted by: its gains and its shapes; a size and an angle count as one.
    pub fn parameters(&self) -> usize {
        let gains = if self.term.kind.about().at_an_angle { 1 } else { self.columns.len() };
        gains + self.term.kind.shape().len()
    }

    /// What of each column is outside the span of `basis`.
    pub fn outside(&self, basis: &Basis) -> Vec<Vec<f64>> {
        self.columns.iter().map(|c| basis.project_out(c)).collect()
    }

    /// Whether gains lie in the range their effect accepts: a fit that ends outside is naming another effect.
    pub fn physical(&self, coefficients: &[f64]) -> bool {
        let gains = self.gains(coefficients);
        self.term.kind.gains().iter().zip(gains).all(|(p, g)| g.is_finite() && g >= p.min && g <= p.max)
    }

    /// The effect's gains, spread over directions, from its coefficients in a fit.
    pub fn gains(&self, coefficients: &[f64]) -> [f64; friction::effects::MAX_GAINS] {
        let mut free = vec![0.0; self.term.free_gains().len()];
        for (a, c) in self.active.iter().zip(coefficients) {
            free[*a] = *c;
        }
        self.term.spread(&free)
    }
}

/// The baseline with some terms.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// What was added.
    pub atoms: Vec<Atom>,
    /// Physics without a name, beside it.
    pub free: Vec<FreeTerm>,
    /// The joint fit.
    pub fit: Fit,
}

impl Hypothesis {
    /// All columns: baseline first, then each atom's.
    pub fn columns<'a>(design: &'a DesignMatrix, atoms: &'a [Atom]) -> Vec<&'a [f64]> {
        let own = atoms.iter().flat_map(|a| a.columns.iter()).map(|c| c.as_slice());
        design.baseline.iter().map(Vec::as_slice).chain(own).collect()
    }

    /// Fits the baseline and `atoms` jointly.
    pub fn new(design: &DesignMatrix, atoms: Vec<Atom>) -> Option<Self> {
        let fit = fit(&Self::columns(design, &atoms), &design.y, &design.blocks, FOLDS)?;
        Some(Self { atoms, free: Vec::new(), fit })
    }

    /// All columns of this hypothesis: baseline, atoms, free forms.
    pub fn all_columns<'a>(&'a self, design: &'a DesignMatrix) -> Vec<&'a [f64]> {
        self.columns_with(design, |_| true)
    }

    /// The same without forms of the time since the start, which no half of a recording tells of the other.
    pub fn lasting_columns<'a>(&'a self, design: &'a DesignMatrix) -> Vec<&'a [f64]> {
        self.columns_with(design, |t| !t.is_of_time())
    }

    /// Penalties of those.
    pub fn lasting_penalties(&self, design: &DesignMatrix) -> Vec<f64> {
        let free = self.free.iter().filter(|t| !t.is_of_time());
        Self::penalties(design, &self.atoms, free)
    }

    /// Penalties of all columns: none on the baseline and on atoms, then those of free forms.
    pub fn penalties<'a>(
        design: &DesignMatrix,
        atoms: &[Atom],
        free: impl IntoIterator<Item = &'a FreeTerm>,
    ) -> Vec<f64> {
        let named = design.baseline.len() + atoms.iter().map(|a| a.columns.len()).sum::<usize>();
        let free = free.into_iter().flat_map(|t| t.penalties.iter().copied());
        std::iter::repeat_n(0.0, named).chain(free).collect()
    }

    fn columns_with<'a>(
        &'a self,
        design: &'a DesignMatrix,
        want: impl Fn(&FreeTerm) -> bool,
    ) -> Vec<&'a [f64]> {
        let free = self.free.iter().filter(|t| want(t)).flat_map(|t| t.columns.iter()).map(Vec::as_slice);
        Self::columns(design, &self.atoms).into_iter().chain(free).collect()
    }

    /// First coefficient of atom `i`.
    pub fn offset(&self, design: &DesignMatrix, i: usize) -> usize {
        design.baseline.len() + self.atoms[..i].iter().map(|a| a.columns.len()).sum::<usize>()
    }

    /// Coefficients of atom `i`.
    pub fn coefficients(&self, design: &DesignMatrix, i: usize) -> &[f64] {
        let from = self.offset(design, i);
        &self.fit.coefficients[from..from + self.atoms[i].columns.len()]
    }

    /// Whether an effect of this kind is among them.
    pub fn has(&self, kind: TermKind) -> bool {
        self.atoms.iter().any(|a| a.term.kind == kind)
    }
}
