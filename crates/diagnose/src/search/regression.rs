//! The regression that is searched.

use crate::findings::nuisance::Declared;
use crate::library::design_matrix::DesignMatrix;
use crate::options::Options;
use crate::preparation::intake::Intake;
use crate::search::extra_columns::{self, Followed};
use crate::search::hypothesis::Hypothesis;

/// The regression that is searched: design matrix, its baseline fit and the nuisances that are columns of it.
#[derive(Clone)]
pub(crate) struct Regression {
    pub design: DesignMatrix,
    pub baseline: Hypothesis,
    /// The baseline without further columns: what a simulation is that leaves them out.
    pub plain: Hypothesis,
    pub declared: Vec<Declared>,
    /// Further columns that the error follows: the last columns of the baseline.
    pub followed: Vec<Followed>,
}

impl Regression {
    /// The regression on the design matrix of `intake`, without further columns. None where mass and friction cannot be told
    /// apart.
    pub fn new(mut design: DesignMatrix, options: &Options) -> Option<Self> {
        let declared = design.declare(&options.per_recording);
        let plain = Hypothesis::new(&design, Vec::new())?;
        Some(Self { design, baseline: plain.clone(), plain, declared, followed: Vec::new() })
    }

    /// With curves over the further columns that the error follows.
    pub fn following(&self, intake: &Intake, options: &Options) -> Option<Self> {
        let mut out = self.clone();
        out.followed = extra_columns::follow(&mut out.design, &intake.extra, options.seed);
        out.fitted()
    }

    /// The same with the delay among the effects.
    pub fn without_delay(&self, intake: &Intake, cutoff: f64, options: &Options) -> Option<Self> {
        let design = DesignMatrix::new(&intake.stretches, cutoff, intake.reversals, false)?;
        let mut out = Self::new(design, options)?;
        let curves: Vec<_> =
            self.followed.iter().flat_map(|f| f.columns(&out.design, &intake.extra)).collect();
        out.design.baseline.extend(curves);
        out.followed.clone_from(&self.followed);
        out.fitted()
    }

    /// Fitted again, with the curves that its baseline has by now.
    fn fitted(mut self) -> Option<Self> {
        self.baseline = Hypothesis::new(&self.design, Vec::new())?;
        self.plain.fit.coefficients.resize(self.design.baseline.len(), 0.0);
        let mut std_errors = self.plain.fit.std_errors().to_vec();
        std_errors.resize(self.design.baseline.len(), 0.0);
        self.plain.fit.set_std_errors(std_errors);
        Some(self)
    }

    /// Number of columns of the plain baseline.
    pub fn plain_columns(&self) -> usize {
        self.design.baseline.len() - self.followed.iter().map(Followed::columns_added).sum::<usize>()
    }
}
