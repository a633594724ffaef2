//! The search: one hypothesis after the other, each judged by sign flips of whole blocks and on blocks held out.

use super::design::Design;
use super::term::{Kind, PlanarScales, Term};
use crate::options::Interrupted;
use crate::regression::linear::{FOLDS, Fit, fit};
use crate::regression::sign_flips::{Family, Scores, block_scores, family, gain_interval};
use crate::search::judgement::LEVEL as SIGNIFICANT;
use friction::effects::MAX_SHAPE;
use identify::planar::Ellipse;
use rayon::prelude::*;
use signals::{Basis, dot};

/// Random signs drawn for a test.
const FLIPS: usize = 999;
/// Share of a column outside the others below which it is not tested.
const OUTSIDE: f64 = 0.1;
/// The same without a shape to choose: it is found by the little that is not of the others.
const OUTSIDE_OF_ONE: f64 = 0.03;
/// Steps of the fit of the ellipse.
const BENDS: usize = 12;
/// Rounds of the search for a shape, each half as wide as the one before.
const ROUNDS: usize = 5;
/// Share of what a term gains that another may lose in its place and still count as good.
const AS_GOOD: f64 = 0.03;

/// The baseline with some terms.
#[derive(Clone)]
pub(super) struct Hypothesis {
    pub terms: Vec<Term>,
    /// Baseline first, then those of each term.
    pub columns: Vec<Vec<f64>>,
    /// Number of columns of the baseline, and which of them is the level.
    pub baseline: usize,
    pub level: usize,
    pub fit: Fit,
    /// What was fitted: the force, moved where the level is linear about an ellipse.
    pub target: Vec<f64>,
    /// The ellipse the level is linear about.
    pub ellipse: Ellipse,
}

impl Hypothesis {
    /// First column of term `i`.
    pub fn offset(&self, i: usize) -> usize {
        self.baseline + self.terms[..i].iter().map(|t| t.free().len()).sum::<usize>()
    }

    /// Coefficients of term `i`.
    pub fn coefficients(&self, i: usize) -> &[f64] {
        let from = self.offset(i);
        &self.fit.coefficients[from..from + self.terms[i].free().len()]
    }

    /// Gains lie in the ranges that their effects accept; mass and level are not negative.
    pub fn physical(&self) -> bool {
        let gains = |i: usize| {
            let term = &self.terms[i];
            if term.kind == Kind::Anisotropy {
                return self.ellipse.c.hypot(self.ellipse.s) < 0.97;
            }
            let parameters = term.kind.about().gains;
            term.free().iter().zip(self.coefficients(i)).all(|(members, c)| {
                members.iter().all(|m| *c >= parameters[*m].min && *c <= parameters[*m].max)
            })
        };
        self.fit.coefficients[0] >= 0.0
            && self.fit.coefficients[self.level] >= 0.0
            && (0..self.terms.len()).all(gains)
    }

    fn has(&self, kind: Kind) -> bool {
        self.terms.iter().any(|t| t.kind == kind)
    }
}

/// Share of a column of this kind outside the others below which it is not tested.
fn outside(kind: Kind) -> f64 {
    if kind.shapes() == 0 { OUTSIDE_OF_ONE } else { OUTSIDE }
}

/// What a search knows.
pub(super) struct Search<'a> {
    pub design: &'a Design,
    pub scales: &'a PlanarScales,
    pub catalogue: &'a [Term],
    /// Columns of each, about a disc.
    pub columns: &'a [Vec<Vec<f64>>],
    /// Squared error that noise alone leaves in all rows.
    pub floor: f64,
    /// Squared error below which nothing is named.
    pub systematic: f64,
    pub max_terms: usize,
    pub seed: u64,
}

/// The baseline, the last hypothesis, and the test of each of its terms.
pub(super) type Searched = (Hypothesis, Hypothesis, Vec<Found>);

/// A term that was found, with its test.
pub(super) struct Found {
    pub p: f64,
    pub term: Term,
}

impl Search<'_> {
    /// Fits the baseline and `terms` jointly; with an anisotropy among them, about the ellipse that fits best.
    pub fn hypothesis(&self, terms: &[Term], start: Ellipse) -> Option<Hypothesis> {
        let bends = terms.iter().any(|t| t.kind == Kind::Anisotropy);
        let mut design = self.design.clone();
        design.ellipse = Ellipse { level: 1.0, ..if bends { start } else { Ellipse::default() } };
        let fixed: Vec<Vec<Vec<f64>>> = terms
            .iter()
            .map(|t| if t.kind == Kind::Anisotropy { Vec::new() } else { t.columns(&design) })
            .collect();
        let baseline = design.baseline();
        let level = design.level();
        for step in 0..BENDS {
            let mut columns = baseline.clone();
            let bent = if bends { design.anisotropy() } else { Vec::new() };
            if bends {
                columns[level] = design.level_column();
            }
            for (term, own) in terms.iter().zip(&fixed) {
                columns.extend(if term.kind == Kind::Anisotropy { bent.clone() } else { own.clone() });
            }
            let target = design.target(&bent);
            let mut blocks = design.blocks.clone();
            // the mass of the baseline is what the acceleration's noise is charged by
            blocks.mass = self.design.blocks.mass;
            let fit = fit(&columns, &target, &blocks, FOLDS)?;
            let hypothesis = Hypothesis {
                terms: terms.to_vec(),
                columns,
                baseline: baseline.len(),
                level,
                fit,
                target,
                ellipse: design.ellipse,
            };
            let Some(i) = terms.iter().position(|t| t.kind == Kind::Anisotropy) else {
                return Some(hypothesis);
            };
            let found = hypothesis.coefficients(i);
            let next =
                Ellipse { level: hypothesis.fit.coefficients[level], c: found[0], s: found[1] }.bounded();
            let moved = (next.c - design.ellipse.c).hypot(next.s - design.ellipse.s)
                + (next.level / design.ellipse.level - 1.0).abs();
            if moved < 1e-7 || step + 1 == BENDS {
                return Some(hypothesis);
            }
            design.ellipse = next;
        }
        None
    }

    /// Held-out squares, and what the shapes cost: ln(n)/2 each in log-likelihood, as in Schwarz's criterion.
    fn cost(&self, h: &Hypothesis) -> f64 {
        let rows: f64 = self.design.share.iter().sum();
        let shapes: usize = h.terms.iter().map(|t| t.kind.shapes()).sum();
        h.fit.heldout_sum() + shapes as f64 * rows.max(2.0).ln() * self.floor / rows.max(1.0)
    }

    /// 95 % interval of the held-out gain from one fit to another.
    pub fn interval(&self, parent: &Hypothesis, child: &Hypothesis) -> [f64; 2] {
        let blocks = &self.design.blocks;
        let weight = self.design.block_weight();
        gain_interval(
            &parent.fit.heldout,
            &child.fit.heldout,
            &weight,
            &blocks.recordings,
            1000,
            self.seed ^ 0x9e37,
        )
    }

    /// What each hypothesis explains of the residual of `h` outside of its columns, most first; one shape of each kind.
    fn ranked(&self, h: &Hypothesis) -> Vec<Term> {
        let basis = Basis::of(&h.columns);
        let explained = |(term, own): (&Term, &Vec<Vec<f64>>)| {
            let mut rest = Basis::of::<Vec<f64>>(&[]);
            let mut sum = 0.0;
            for column in own {
                let beyond = basis.project_out(column);
                if dot(&beyond, &beyond) < outside(term.kind).powi(2) * dot(column, column) {
                    if term.kind == Kind::Anisotropy {
                        // a size without an angle is none
                        return (0.0, *term);
                    }
                    continue;
                }
                let own = rest.project_out(&beyond);
                let size = dot(&own, &own);
                if size > 1e-12 * dot(column, column) && size > 0.0 {
                    sum += dot(&own, &h.fit.residual).powi(2) / size;
                    rest.push(&beyond);
                }
            }
            let parameters = (own.len() + term.kind.shapes()) as f64;
            (sum - parameters * 4.0 * self.floor / self.rows(), *term)
        };
        let mut all: Vec<(f64, Term)> =
            self.catalogue.par_iter().zip(self.columns).map(explained).filter(|(s, _)| *s > 0.0).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut kinds: Vec<Kind> = h.terms.iter().map(|t| t.kind).collect();
        let mut out = Vec::new();
        for (_, term) in all {
            if !kinds.contains(&term.kind) {
                kinds.push(term.kind);
                out.push(term);
            }
        }
        out
    }

    fn rows(&self) -> f64 {
        self.design.share.iter().sum::<f64>().max(1.0)
    }

    /// The shape of term `i` that leaves least.
    fn refined(&self, h: Hypothesis, i: usize) -> Hypothesis {
        let kind = h.terms[i].kind;
        let mut best = h;
        for axis in 0..kind.shapes().min(MAX_SHAPE) {
            let Some((low, high)) = kind.range(self.scales, axis) else { continue };
            let log = low > 0.0;
            let place = |x: f64| if log { x.ln() } else { x };
            let (low, high) = (place(low), place(high));
            let mut width = (high - low) / 12.0;
            for _ in 0..ROUNDS {
                let at = place(best.terms[i].shape[axis]);
                for by in [-0.7 * width, 0.7 * width] {
                    let moved = (at + by).clamp(low, high);
                    let mut terms = best.terms.clone();
                    terms[i].shape[axis] = if log { moved.exp() } else { moved };
                    if let Some(other) = self.hypothesis(&terms, best.ellipse)
                        && dot(&other.fit.residual, &other.fit.residual)
                            < dot(&best.fit.residual, &best.fit.residual)
                    {
                        best = other;
                    }
                }
                width *= 0.6;
            }
        }
        best
    }

    /// Max-statistic test of every column of the catalogue against the residual of `parent`; noise is what `child` leaves.
    fn test(&self, parent: &Hypothesis, child: &Hypothesis) -> (Vec<usize>, Family) {
        let basis = Basis::of(&parent.columns);
        let noise = &child.fit.residual;
        let spread = (dot(noise, noise) / noise.len().max(1) as f64).sqrt();
        let blocks = &self.design.blocks;
        let score = |(i, column): (usize, &Vec<f64>)| {
            let rest = basis.project_out(column);
            let size = dot(&rest, &rest).sqrt();
            (size > outside(self.catalogue[i].kind) * dot(column, column).sqrt()).then(|| {
                let scores = |residual: &[f64]| block_scores(&rest, residual, blocks);
                (i, scores(&parent.fit.residual), scores(noise), size * spread)
            })
        };
        let all: Vec<(usize, &Vec<f64>)> =
            self.columns.iter().enumerate().flat_map(|(i, own)| own.iter().map(move |c| (i, c))).collect();
        let tested: Vec<(usize, Scores, Scores, f64)> = all.into_par_iter().filter_map(score).collect();
        let (mut of, mut observed, mut noises, mut scale) = (vec![], vec![], vec![], vec![]);
        for (i, o, n, s) in tested {
            of.push(i);
            observed.push(o);
            noises.push(n);
            scale.push(s);
        }
        (of, family(&observed, &noises, &scale, FLIPS, self.seed))
    }

    /// Adds what is missing until nothing is significant. Returns the baseline, the last hypothesis, and the test of each term.
    ///
    /// # Errors
    /// `tell` asked for an early end.
    pub fn run(
        &self,
        tell: &dyn Fn(f32) -> Result<(), Interrupted>,
    ) -> Result<Option<Searched>, Interrupted> {
        let Some(baseline) = self.hypothesis(&[], Ellipse::default()) else { return Ok(None) };
        let mut found: Vec<Found> = Vec::new();
        let mut now = baseline.clone();
        while found.len() < self.max_terms {
            tell(found.len() as f32 / self.max_terms as f32)?;
            let few = self.ranked(&now);
            let tried = few.iter().take(4).filter_map(|term| {
                let terms: Vec<Term> = now.terms.iter().copied().chain([*term]).collect();
                let h = self.hypothesis(&terms, Ellipse { level: 1.0, ..now.ellipse })?;
                let h = self.refined(h, terms.len() - 1);
                h.physical().then_some(h)
            });
            let Some(next) = tried.min_by(|a, b| self.cost(a).total_cmp(&self.cost(b))) else { break };
            let term = next.terms[next.terms.len() - 1];
            let (of, outcome) = self.test(&now, &next);
            let p = of
                .iter()
                .zip(&outcome.p)
                .filter(|(i, _)| self.catalogue[**i].kind == term.kind)
                .map(|(_, p)| *p)
                .fold(1.0, f64::min);
            let gain = now.fit.heldout_sum() - next.fit.heldout_sum();
            if p > SIGNIFICANT || self.interval(&now, &next)[0] <= 0.0 || gain <= self.systematic {
                break;
            }
            found.push(Found { p, term });
            now = next;
            self.simplify(&mut now, &mut found);
        }
        for (f, term) in found.iter_mut().zip(&now.terms) {
            f.term = *term;
        }
        Ok(Some((baseline, now, found)))
    }

    /// Takes out what no longer gains beside the others.
    fn simplify(&self, now: &mut Hypothesis, found: &mut Vec<Found>) {
        let mut i = 0;
        while i + 1 < now.terms.len() {
            let mut terms = now.terms.clone();
            terms.remove(i);
            match self.hypothesis(&terms, now.ellipse) {
                Some(without)
                    if self.interval(&without, now)[0] <= 0.0
                        || without.fit.heldout_sum() - now.fit.heldout_sum() <= self.systematic =>
                {
                    found.remove(i);
                    *now = without;
                }
                _ => i += 1,
            }
        }
    }

    /// `h` without term `i`.
    pub fn without(&self, h: &Hypothesis, i: usize) -> Option<Hypothesis> {
        let mut terms = h.terms.clone();
        terms.remove(i);
        self.hypothesis(&terms, h.ellipse)
    }

    /// Effects that explain as much in the place of term `i`.
    pub fn rivals(&self, h: &Hypothesis, i: usize) -> Vec<&'static str> {
        let Some(without) = self.without(h, i) else { return Vec::new() };
        let own = h.terms[i].kind;
        let gained = without.fit.heldout_sum() - h.fit.heldout_sum();
        let as_good = |term: &Term| {
            let mut terms = h.terms.clone();
            terms[i] = *term;
            let rival = self.refined(self.hypothesis(&terms, Ellipse::default())?, i);
            let lost = rival.fit.heldout_sum() - h.fit.heldout_sum();
            (rival.physical() && (self.interval(&rival, h)[0] <= 0.0 || lost < AS_GOOD * gained))
                .then(|| term.kind.about().id)
        };
        let ranked = self.ranked(&without);
        let mut out: Vec<&str> = ranked
            .iter()
            .filter(|t| t.kind != own && !h.has(t.kind) && t.kind.about().id != own.about().id)
            .take(3)
            .filter_map(as_good)
            .collect();
        out.dedup();
        out
    }

    /// Of each kind that is not among the terms of `h`: whether the motion shows it, and a 95 % bound of its force, rms, N.
    pub fn bounds(&self, h: &Hypothesis, kinds: &[Kind]) -> Vec<(Kind, Option<f64>)> {
        let basis = Basis::of(&h.columns);
        let noise = dot(&h.fit.residual, &h.fit.residual).sqrt() / (self.rows()).sqrt();
        let of = |kind: &Kind| {
            let mut bound: Option<f64> = None;
            let own = self.catalogue.iter().zip(self.columns).filter(|(t, _)| t.kind == *kind);
            let mut hidden = false;
            for column in own.flat_map(|(_, columns)| columns) {
                let rest = basis.project_out(column);
                let (own, all) = (dot(&rest, &rest), dot(column, column));
                if own > outside(*kind).powi(2) * all && own > 0.0 {
                    let gain = dot(&rest, &h.fit.residual).abs() / own;
                    // a filter makes neighbours alike: half as many rows speak
                    let std = 1.5 * noise / own.sqrt();
                    let force = (gain + 1.96 * std) * (all / self.rows()).sqrt();
                    bound = Some(bound.map_or(force, |b: f64| b.max(force)));
                } else {
                    hidden = true;
                }
            }
            if *kind == Kind::Anisotropy && hidden {
                bound = None;
            }
            (*kind, bound)
        };
        kinds.par_iter().filter(|k| !h.has(**k)).map(of).collect()
    }
}
