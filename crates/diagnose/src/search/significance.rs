//! Family-wise p values of terms: each against the best of every testable column under random signs of blocks.
//!
//! A column counts outside of the parent, the hypothesis without the term. That part is never formed: its scores follow from
//! inner products with the columns of the parent, block by block, and those are taken once for all terms of a hypothesis.

use crate::regression::linear::{gram, inverse};
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::judgement::{FLIPS, OUTSIDE, Search};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use signals::{block_products, dot, random_signs};

/// Terms of a hypothesis that are tested, and the hypothesis without them.
#[derive(Clone, Copy)]
pub struct Claim<'a> {
    pub without: &'a Hypothesis,
    pub atoms: &'a [Atom],
}

/// A parent in terms of the columns that all parents have between them.
struct Parent<'a> {
    claim: Claim<'a>,
    /// Where its columns stand.
    at: Vec<usize>,
    /// Inverse of their inner products.
    cover: DMatrix<f64>,
    /// By block and column: inner products with the residual of the parent, and with the noise.
    observed: DMatrix<f64>,
    noise: DMatrix<f64>,
}

/// A column outside of a parent, in standard deviations.
struct Score {
    /// Size of the sum over blocks.
    t: f64,
    /// What noise is in each block.
    noise: Vec<f64>,
    /// Largest sum that any signs give.
    most: f64,
    /// It is one of the term that is tested.
    claimed: bool,
}

impl Search<'_> {
    /// Family-wise p of the best column of `atoms` against `parent`.
    pub fn significance(&self, parent: &Hypothesis, child: &Hypothesis, atoms: &[Atom]) -> f64 {
        self.significances(child, &[Claim { without: parent, atoms }]).first().copied().unwrap_or(1.0)
    }

    /// Family-wise p of the best column of each claim; noise is what `child` leaves.
    pub fn significances(&self, child: &Hypothesis, claims: &[Claim]) -> Vec<f64> {
        let (design, noise) = (self.design, &child.fit.residual);
        let edges = &design.blocks.edges;
        let mut fixed: Vec<&[f64]> = Vec::new();
        let parents: Vec<Option<Parent>> = claims
            .iter()
            .map(|claim| {
                let columns = Hypothesis::columns(design, &claim.without.atoms);
                let mut at = Vec::with_capacity(columns.len());
                for column in &columns {
                    let known = fixed.iter().position(|f| std::ptr::eq(*f, *column));
                    at.push(known.unwrap_or(fixed.len()));
                    if known.is_none() {
                        fixed.push(column);
                    }
                }
                let gram = gram(&columns, 0..noise.len());
                let by_block = |residual: &[f64]| {
                    let products = block_products(residual, &columns, edges);
                    DMatrix::from_row_slice(design.blocks.len(), columns.len(), &products)
                };
                let (observed, noise) = (by_block(&claim.without.fit.residual), by_block(noise));
                Some(Parent { claim: *claim, at, cover: inverse(&gram)?, observed, noise })
            })
            .collect();
        let shared = fixed.len();
        fixed.extend([design.y.as_slice(), noise.as_slice()]);
        let testable = self.catalogue.testable();
        // columns that several atoms share are tested once
        let mut columns: Vec<(&[f64], Vec<&Atom>)> = Vec::new();
        let mut known = std::collections::HashMap::new();
        for atom in testable.into_iter().chain(claims.iter().flat_map(|c| c.atoms)) {
            for column in atom.columns.iter() {
                let index = *known.entry(column.as_ptr()).or_insert(columns.len());
                if index == columns.len() {
                    columns.push((column.as_slice(), Vec::new()));
                }
                columns[index].1.push(atom);
            }
        }
        let spread = (dot(noise, noise) / noise.len().max(1) as f64).sqrt();
        let scores: Vec<Vec<Option<Score>>> = columns
            .par_iter()
            .map(|(column, atoms)| {
                let products = block_products(column, &fixed, edges);
                let products = DMatrix::from_row_slice(design.blocks.len(), fixed.len(), &products);
                let own = dot(column, column);
                let of =
                    |parent: &Option<Parent>| parent.as_ref()?.score(&products, shared, own, spread, atoms);
                parents.iter().map(of).collect()
            })
            .collect();
        let signs = random_signs(FLIPS, design.blocks.len(), self.seed);
        (0..claims.len())
            .map(|i| {
                let of: Vec<&Score> = scores.iter().filter_map(|s| s[i].as_ref()).collect();
                let best = of.iter().filter(|s| s.claimed).map(|s| s.t).fold(f64::NEG_INFINITY, f64::max);
                if best == f64::NEG_INFINITY {
                    return 1.0;
                }
                let mut near: Vec<&Score> = of.into_iter().filter(|s| s.most >= best).collect();
                near.sort_by(|a, b| b.most.total_cmp(&a.most));
                let reaches = |signs: &&Vec<f64>| near.iter().any(|s| dot(&s.noise, signs).abs() >= best);
                let above = signs.par_iter().filter(reaches).count();
                (above + 1) as f64 / (FLIPS + 1) as f64
            })
            .collect()
    }
}

impl Parent<'_> {
    /// The score of a column with squared length `own`, by its inner products with the `shared` columns, the force and the noise;
    /// None if the column lies in the span of the parent's columns.
    fn score(
        &self,
        products: &DMatrix<f64>,
        shared: usize,
        own: f64,
        spread: f64,
        atoms: &[&Atom],
    ) -> Option<Score> {
        let with = products.select_columns(&self.at);
        let along = &self.cover * DVector::from_fn(with.ncols(), |j, _| with.column(j).sum());
        let inside = (0..with.ncols()).map(|j| along[j] * with.column(j).sum()).sum::<f64>();
        let size = (own - inside).max(0.0).sqrt();
        if !(size > OUTSIDE * own.sqrt()) {
            return None;
        }
        let fitted = DVector::from_column_slice(&self.claim.without.fit.coefficients);
        let observed = products.column(shared) - &with * fitted - &self.observed * &along;
        let noise = products.column(shared + 1) - &self.noise * &along;
        // Half the blockwise, half the independent estimate, as everywhere.
        let deviation = (0.5 * noise.norm_squared() + 0.5 * (size * spread).powi(2)).sqrt();
        let noise: Vec<f64> = noise.iter().map(|x| x / deviation).collect();
        let claimed = self.claim.atoms.iter().any(|a| atoms.iter().any(|b| a.term == b.term));
        let t = (observed.sum() / deviation).abs();
        (deviation > 0.0).then(|| Score { t, most: noise.iter().map(|x| x.abs()).sum(), noise, claimed })
    }
}
