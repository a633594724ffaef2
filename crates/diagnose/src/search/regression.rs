//! The regression that is searched.

use crate::findings::nuisance::Declared;
use crate::library::design_matrix::DesignMatrix;
use crate::options::Options;
use crate::preparation::intake::Intake;
use crate::search::extra_columns::{self, Followed};
use crate::search::hypothesis::Hypothesis;

/// The regression that is searched: design matrix, its baseline fit and the nuisances that are columns of it.
pub(crate) struct Regression {
    pub design: DesignMatrix,
    pub baseline: Hypothesis,
    pub declared: Vec<Declared>,
    /// Further columns that the error follows: the last columns of the baseline.
    pub followed: Vec<Followed>,
}

impl Regression {
    /// The regression on the design matrix of `intake`. None where mass and friction cannot be told apart.
    pub fn new(mut design: DesignMatrix, intake: &Intake, options: &Options) -> Option<Self> {
        let declared = design.declare(&options.per_recording);
        let followed = extra_columns::follow(&mut design, &intake.extra, options.seed);
        let baseline = Hypothesis::new(&design, Vec::new())?;
        Some(Self { design, baseline, declared, followed })
    }
}
