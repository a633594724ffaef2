//! What a search knows, and how it judges one hypothesis against another.

use crate::library::design_matrix::DesignMatrix;
use crate::library::scales::Scales;
use crate::library::term::Term;
use crate::regression::linear::{FOLDS, Fit};
use crate::regression::sign_flips::{Family, Scores, block_scores, family, gain_interval};
use crate::search::catalogue::Catalogue;
use crate::search::hypothesis::{Atom, Hypothesis};
use rayon::prelude::*;
use signals::{Basis, dot};

/// Random signs drawn for a test, so that the smallest p value is 1/1000.
pub const FLIPS: usize = 999;
/// Family-wise level of a step.
pub const LEVEL: f64 = 0.01;
/// Cosine above which two explanations count as one on a recording.
pub const COLLINEAR: f64 = 0.95;
/// Share of a column outside the columns of the parent below which it is not tested.
pub const OUTSIDE: f64 = 0.02;
/// Share of what a term gains that another may lose in its place and still count as good.
const AS_GOOD: f64 = 0.03;
/// Standard errors by which a mass has to be below zero to be refused.
const SURELY: f64 = 2.0;

/// Share of a delay that is left where something else takes it back.
const TAKEN_BACK: f64 = 0.3;

/// Squared error over that of the floor from which on a gain may be plain.
const PLAIN: f64 = 4.0;
/// Share of the squared error above the floor that is nearly all of it.
const NEARLY_ALL: f64 = 0.8;
/// Share of a gain that other parts of the recording may lose.
const HARDLY: f64 = 0.03;
/// Least share of a gain outside the part that gains most.
const OF_ONE: f64 = 0.2;

/// What `unzip` makes of pairs.
type Unzipped<A, B> = (Vec<A>, Vec<B>);

/// Settings of the search.
#[derive(Debug, Clone, Copy)]
pub struct Search<'a> {
    /// The regression.
    pub design: &'a DesignMatrix,
    /// The same with one more draw of the sensors' noise.
    pub noisy: &'a DesignMatrix,
    /// The catalogue on it.
    pub catalogue: &'a Catalogue,
    /// Scales for refining shapes.
    pub scales: &'a Scales,
    /// Squared error that noise alone leaves.
    pub floor: f64,
    /// Squared error of the sensors that may repeat with the motion as physics does: nothing smaller is named.
    pub systematic: f64,
    /// Most terms.
    pub max_terms: usize,
    /// Most gains and shapes of all terms together: the rows tell no more of them apart.
    pub max_parameters: usize,
    /// Hypotheses carried along.
    pub width: usize,
    /// Seed of every draw.
    pub seed: u64,
}

impl Search<'_> {
    /// Whether `atoms` already contain this effect.
    pub fn has(&self, atoms: &[Atom], term: &Term) -> bool {
        let stroke = self.scales.stroke.1 - self.scales.stroke.0;
        atoms.iter().any(|a| a.term.is_one_with(term, stroke))
    }

    /// Whether all `atoms` are distinct effects.
    pub fn are_apart(&self, atoms: &[Atom]) -> bool {
        (1..atoms.len()).all(|i| !self.has(&atoms[..i], &atoms[i].term))
    }

    /// Whether `rival`, with another term in the place of one of `best`, explains what it does; `without`: neither's.
    pub fn is_as_good(&self, rival: &Hypothesis, best: &Hypothesis, without: Option<&Hypothesis>) -> bool {
        let beyond_best = |h: &Hypothesis| h.fit.heldout_sum() - best.fit.heldout_sum();
        !self.gains_surely(&rival.fit, &best.fit)
            || beyond_best(rival) < AS_GOOD * without.map_or(0.0, beyond_best)
    }

    /// What term `i` adds to the prediction, outside the span of `basis`.
    pub fn contribution(&self, h: &Hypothesis, i: usize, basis: &Basis) -> Vec<f64> {
        let mut sum = vec![0.0; self.design.y.len()];
        for (c, column) in h.coefficients(self.design, i).iter().zip(h.atoms[i].columns.iter()) {
            for (s, x) in sum.iter_mut().zip(column.iter()) {
                *s += c * x;
            }
        }
        basis.project_out(&sum)
    }

    /// Whether all effects are distinct, every gain is within its effect's range, nothing moves the force forward in time that
    /// something else moves back, and the mass is not significantly negative, unless the baseline's already is. A mass that does
    /// not show has either sign.
    pub fn physical(&self, h: &Hypothesis) -> bool {
        let mass = h.fit.coefficients.first().copied().unwrap_or(0.0);
        // only a mass below zero asks for its standard error
        let surely_negative = || mass + SURELY * h.fit.std_errors().first().copied().unwrap_or(0.0) < 0.0;
        self.are_apart(&h.atoms)
            && (mass >= 0.0 || self.design.blocks.mass < 0.0 || !surely_negative())
            && (0..h.atoms.len()).all(|i| h.atoms[i].physical(h.coefficients(self.design, i)))
            && !self.moves_back_and_forth(h)
    }

    /// Whether two effects that move the force in time take each other back. What they leave is its curvature: the trace of a filter
    /// that it and the motion did not share, and neither a delay nor a lag.
    fn moves_back_and_forth(&self, h: &Hypothesis) -> bool {
        let movers: Vec<usize> =
            (0..h.atoms.len()).filter(|i| h.atoms[*i].term.kind.moves_in_time()).collect();
        if movers.len() < 2 {
            return false;
        }
        let late = self.design.rows(|t| t.pass(&t.late()));
        let delay = |i: &usize| dot(&self.contribution(h, *i, &Basis::default()), &late);
        let delays: Vec<f64> = movers.iter().map(delay).collect();
        let taken_back = |a: f64, b: f64| (a + b).abs() < TAKEN_BACK * a.abs().max(b.abs());
        (1..delays.len()).any(|i| delays[..i].iter().any(|other| taken_back(delays[i], *other)))
    }

    /// Tests of columns, each with what it belongs to, outside `basis`: against the residual of `parent`, noise taken from `child`.
    pub fn family<L: Copy + Send + Sync>(
        &self,
        basis: &Basis,
        parent: &Fit,
        child: &Fit,
        columns: Vec<(L, &[f64])>,
    ) -> (Vec<L>, Family) {
        let (blocks, noise) = (&self.design.blocks, &child.residual);
        let spread = (dot(noise, noise) / noise.len().max(1) as f64).sqrt();
        let score = |(of, column): &(L, &[f64])| {
            let rest = basis.project_out(column);
            let size = dot(&rest, &rest).sqrt();
            (size > OUTSIDE * dot(column, column).sqrt()).then(|| {
                let scores = |residual: &[f64]| block_scores(&rest, residual, blocks);
                ((*of, scores(&parent.residual)), (scores(noise), size * spread))
            })
        };
        let ((of, observed), (noise, scale)): (Unzipped<L, Scores>, Unzipped<Scores, f64>) =
            columns.par_iter().filter_map(score).unzip();
        (of, family(&observed, &noise, &scale, FLIPS, self.seed))
    }

    /// 95 % interval of the held-out gain from `parent` to `child`.
    pub fn interval(&self, parent: &Hypothesis, child: &Hypothesis) -> [f64; 2] {
        self.gains(&parent.fit, &child.fit)
    }

    /// Whether one fit surely gains over another on blocks that it was not fitted on: the interval of the gain is above zero, or
    /// [`Self::explains_several_parts`].
    pub fn gains_surely(&self, without: &Fit, with: &Fit) -> bool {
        self.gains(without, with)[0] > 0.0 || self.explains_several_parts(without, with)
    }

    /// Whether a gain is nearly all that there is to gain, and comes from several parts of the recording. Where few blocks show an
    /// effect, as the fast ones show inertia, a draw of blocks may hold none of them, and the interval of the gain reaches zero
    /// however plain the gain is in each.
    pub fn explains_several_parts(&self, without: &Fit, with: &Fit) -> bool {
        let (before, after) = (without.heldout_sum(), with.heldout_sum());
        let blocks: Vec<f64> = without.heldout.iter().zip(&with.heldout).map(|(b, a)| b - a).collect();
        let parts: Vec<f64> = (0..FOLDS)
            .map(|fold| blocks[fold * blocks.len() / FOLDS..(fold + 1) * blocks.len() / FOLDS].iter().sum())
            .collect();
        let gained: f64 = parts.iter().map(|g| g.max(0.0)).sum();
        let lost = gained - parts.iter().sum::<f64>();
        let most = parts.iter().copied().fold(0.0, f64::max);
        before > PLAIN * self.floor
            && before - after > NEARLY_ALL * (before - self.floor)
            && lost < HARDLY * gained
            && gained - most > OF_ONE * gained
    }

    /// 95 % interval of the held-out gain from one fit to another.
    pub fn gains(&self, parent: &Fit, child: &Fit) -> [f64; 2] {
        gain_interval(
            &parent.heldout,
            &child.heldout,
            &self.design.block_weight(),
            &self.design.blocks.recordings,
            1000,
            self.seed ^ 0x9e37,
        )
    }

    /// Held-out squares, and what the shapes cost: they were chosen on all the data, which holding out does not see.
    /// ln(n)/2 each in log-likelihood, as in Schwarz's criterion.
    pub fn cost(&self, h: &Hypothesis) -> f64 {
        let rows = self.design.effective_rows();
        let shapes: usize = h.atoms.iter().map(|a| a.term.kind.shape().len()).sum();
        h.fit.heldout_sum() + shapes as f64 * rows.max(2.0).ln() * self.floor / rows.max(1.0)
    }
}
