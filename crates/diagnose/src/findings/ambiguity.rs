//! What else it could be, what was ruled out, and what this motion cannot show.

use crate::experiment::other_means::elsewhere;
use crate::library::design_matrix::DesignMatrix;
use crate::library::term::TermKind;
use crate::regression::sign_flips::block_scores;
use crate::result::{Blind, Rejected};
use crate::search::catalogue::{CONCEALED, is_shown};
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::judgement::{COLLINEAR, Search};
use crate::search::overlap::Overlap;
use crate::search::refine::ROUGH;
use friction::effects::{About, CATALOGUE};
use friction::{Dimension, Geometry, Unit};
use nalgebra::DVector;
use rayon::prelude::*;
use signals::{Basis, dot};
use std::borrow::Borrow;

/// What makes the moments around reversals that are set aside shorter.
const FASTER_REVERSALS: &str =
    "reverse faster, or record position and velocity with less noise: the direction is known sooner then";

/// Share of an effect in the samples in use below which a recording is said to be blind to it.
const SET_ASIDE: f64 = 0.05;

/// Another explanation as good as the one that was named.
#[derive(Debug, Clone)]
pub struct Rival {
    /// Effect.
    pub about: &'static About,
    /// The joint fit with it, as the last term, in place of the other; None where no motion tells them apart.
    pub fit: Option<Hypothesis>,
}

/// Other effects that explain the terms of `found` as well as each of them does.
pub fn rivals(search: &Search, found: &Hypothesis) -> Vec<Vec<Rival>> {
    let overlap =
        Overlap::new(search.catalogue.testable(), &Hypothesis::columns(search.design, &found.atoms));
    (0..found.atoms.len()).into_par_iter().map(|i| equivalents(search, found, &overlap, i)).collect()
}

fn equivalents(search: &Search, found: &Hypothesis, overlap: &Overlap, i: usize) -> Vec<Rival> {
    let design = search.design;
    let mut others = found.atoms.clone();
    let named = others.remove(i);
    let basis = Basis::of(&Hypothesis::columns(design, &others));
    let contribution = search.contribution(found, i, &basis);
    let size = dot(&contribution, &contribution);
    let mut out = Vec::new();
    let without = Hypothesis::new(design, others.clone());
    let from = found.offset(design, i);
    let own = from..from + named.columns.len();
    let part = |c: usize| if own.contains(&c) { found.fit.coefficients[c] } else { 0.0 };
    let all = found.fit.coefficients.len();
    let Some(span) =
        overlap.span((0..all).filter(|c| !own.contains(c)).collect(), DVector::from_fn(all, |c, _| part(c)))
    else {
        return out;
    };
    for kind in TermKind::all() {
        if found.atoms.iter().any(|a| a.term.kind == kind) {
            continue;
        }
        let best = (0..overlap.atoms.len())
            .filter(|a| overlap.atoms[*a].term.kind == kind)
            .map(|a| (overlap.captured(&span, a), overlap.atoms[a]))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((captured, atom)) = best else { continue };
        // A grid point is not the best shape yet: let in a little less and refine.
        if captured < 0.8 * size {
            continue;
        }
        let mut atoms = others.clone();
        atoms.push(atom.clone());
        let Some(rival) = Hypothesis::new(design, atoms).map(|h| search.refine(h, ROUGH)) else { continue };
        let Some(theirs) = rival.atoms.last().filter(|_| search.physical(&rival)) else { continue };
        if Basis::of(&theirs.outside(&basis)).captured(&contribution) < COLLINEAR * COLLINEAR * size {
            continue;
        }
        if search.is_as_good(&rival, found, without.as_ref()) {
            out.push(Rival { about: kind.about(), fit: Some(rival) });
        }
    }
    let id = named.term.kind.id();
    let twins = CATALOGUE.iter().filter(|a| a.twin.is_some_and(|twin| twin.of.contains(&id)));
    out.extend(twins.map(|about| Rival { about, fit: None }));
    out
}

/// Effects this motion, or its sensors, cannot show, each with what would, where that is no motion, or with the effect
/// at a middling shape, where it may be one. `whole` is the design matrix with nothing set aside.
pub fn blind(
    search: &Search,
    found: &Hypothesis,
    whole: &DesignMatrix,
    unavailable: &[(&'static str, &'static str)],
    geometry: Geometry,
) -> Vec<(Blind, Option<Atom>)> {
    let design = search.design;
    let names = [
        "mass",
        "Coulomb friction forward",
        "Coulomb friction backward",
        "viscous friction forward",
        "viscous friction backward",
    ];
    let blind = |about: &About, because: String, unavailable: bool| Blind {
        effect: about.id.into(),
        because,
        experiment: elsewhere(about, unavailable).unwrap_or_default().into(),
    };
    let basis = Basis::of(&Hypothesis::columns(design, &found.atoms));
    // what no motion separates from something else
    let mut out: Vec<(Blind, Option<Atom>)> = CATALOGUE
        .iter()
        .filter_map(|about| Some((blind(about, about.twin?.because.into(), false), None)))
        .collect();
    for kind in TermKind::all() {
        let id = kind.id();
        if let Some((_, because)) = unavailable.iter().find(|(e, _)| *e == id) {
            out.push((blind(kind.about(), (*because).into(), true), None));
            continue;
        }
        let atoms: Vec<&Atom> = search.catalogue.atoms.iter().filter(|a| a.term.kind == kind).collect();
        // none: not to be considered, told by comparing the channels, or part of the baseline already
        let Some(middle) = atoms.get(atoms.len() / 2) else { continue };
        if found.atoms.iter().any(|a| a.term.kind == kind) {
            continue;
        }
        let here = middle.term.shape;
        let middling = || atoms.iter().filter(|a| a.term.shape == here);
        if atoms.iter().any(|a| is_shown(a)) {
            out.extend(
                over_before_seen(search, found, whole, &basis, middling(), geometry).map(|b| (b, None)),
            );
            continue;
        }
        let visible = atoms.iter().map(|a| a.visible).fold(0.0, f64::max);
        let because = if visible >= CONCEALED {
            let reliable = atoms.iter().map(|a| a.reliable).fold(f64::NEG_INFINITY, f64::max);
            format!(
                "sensor noise covers it: only {:.0} % of its signature is signal",
                100.0 * reliable.max(0.0)
            )
        } else if visible == 0.0
            && atoms.iter().all(|a| a.columns.is_empty())
            && atoms.iter().all(|a| a.visible == 0.0)
        {
            "this motion never excites it".to_string()
        } else {
            // The baseline column closest to it tells a person what absorbs it.
            let closest = atoms.first().and_then(|a| {
                let column = design.columns(&a.term).into_iter().next()?;
                let size = dot(&column, &column).sqrt();
                design
                    .baseline
                    .iter()
                    .zip(design.present.iter().map(|i| names[*i]))
                    .map(|(b, n)| (dot(b, &column).abs() / (size * dot(b, b).sqrt()).max(1e-300), n))
                    .max_by(|a, b| a.0.total_cmp(&b.0))
            });
            match closest {
                Some((cosine, name)) if cosine > 0.9 => {
                    format!(
                        "collinear with {name} on this motion (cosine {cosine:.3}, {:.1} % left)",
                        100.0 * visible
                    )
                }
                _ => format!("absorbed by the baseline on this motion ({:.1} % of it left)", 100.0 * visible),
            }
        };
        // in the form this recording has the channels for
        let size = |a: &&&Atom| power(&design.columns(&a.term));
        let to_show =
            middling().max_by(|a, b| size(a).total_cmp(&size(b))).filter(|_| kind.about().shown_by_motion);
        out.push((blind(kind.about(), because, false), to_show.map(|a| (**a).clone())));
    }
    out
}

/// Says of an effect that acts after a reversal, at one shape, that it is over before the direction is known: one as
/// strong as the noise floor would not be seen. `whole` is the design matrix with nothing set aside.
fn over_before_seen<'a>(
    search: &Search,
    found: &Hypothesis,
    whole: &DesignMatrix,
    basis: &Basis,
    variants: impl Iterator<Item = &'a &'a Atom>,
    geometry: Geometry,
) -> Option<Blind> {
    let design = search.design;
    let rows = design.effective_rows();
    // in its simplest form that is anything at all
    let (atom, all) = variants
        .map(|a| (*a, power(&whole.columns(&a.term))))
        .filter(|(_, all)| *all > 0.0)
        .min_by_key(|(a, _)| a.columns.len())?;
    let kind = atom.term.kind;
    let parameter = kind
        .shape()
        .first()
        .filter(|p| [Dimension::TIME, Dimension::LENGTH, Dimension::VELOCITY].contains(&p.dimension))?;
    let left = power(&design.columns(&atom.term)) / all;
    let unseen = |(_, bound): (f64, f64)| bound * bound / left * rows > search.floor;
    let bound = upper_bound(design, basis, atom, &found.fit.residual, rows);
    (left < SET_ASIDE && bound.is_none_or(unseen)).then(|| Blind {
        effect: kind.id().into(),
        because: format!(
            "a {} of {:.1e} {} or less is over within the moments around reversals in which the direction is not known",
            parameter.name,
            atom.term.shape[0],
            parameter.unit(geometry)
        ),
        experiment: FASTER_REVERSALS.into(),
    })
}

/// Effects that were tested beside everything that was found and are not there, with a 95 % upper bound of
/// their root-mean-square force over all samples, in use or not: `whole` is the design matrix with nothing
/// set aside. `besides`: effects that are not ruled out.
pub fn rejected(
    search: &Search,
    found: &Hypothesis,
    whole: &DesignMatrix,
    besides: &[String],
    unit: Unit,
) -> Vec<Rejected> {
    let design = search.design;
    let basis = Basis::of(&Hypothesis::columns(design, &found.atoms));
    let rows = design.effective_rows();
    let mut out = Vec::new();
    for kind in TermKind::all() {
        let id = kind.id();
        if found.atoms.iter().any(|a| a.term.kind == kind) || besides.iter().any(|e| e == id) {
            continue;
        }
        let bound = search
            .catalogue
            .testable()
            .into_iter()
            .filter(|a| a.term.kind == kind && is_shown(a))
            .filter_map(|a| Some((upper_bound(design, &basis, a, &found.fit.residual, rows)?, a)))
            .max_by(|a, b| a.0.0.total_cmp(&b.0.0));
        if let Some(((_, bound), atom)) = bound {
            let left = power(&atom.columns) / power(&whole.columns(&atom.term)).max(1e-300);
            let upper_bound = bound / left.clamp(1e-12, 1.0).sqrt();
            out.push(Rejected { effect: id.into(), upper_bound, unit: unit.to_string() });
        }
    }
    out
}

/// Sum of squares over all columns.
fn power(columns: &[impl Borrow<Vec<f64>>]) -> f64 {
    columns.iter().map(|c| dot(c.borrow(), c.borrow())).sum()
}

/// What the atom captures of the residual, and the upper bound of its force in the samples in use.
fn upper_bound(
    design: &DesignMatrix,
    basis: &Basis,
    atom: &Atom,
    residual: &[f64],
    rows: f64,
) -> Option<(f64, f64)> {
    let (mut captured, mut square) = (0.0, 0.0);
    for column in atom.columns.iter() {
        let rest = basis.project_out(column);
        let power = dot(&rest, &rest);
        if power <= 1e-4 * dot(column, column) {
            continue;
        }
        let scores = block_scores(&rest, residual, &design.blocks);
        let value = scores.iter().sum::<f64>() / power;
        let deviation = dot(&scores, &scores).sqrt() / power;
        captured = f64::max(captured, value * value * power);
        square += (value.abs() + 1.645 * deviation).powi(2) * dot(column, column);
    }
    (square > 0.0 && rows > 0.0).then(|| (captured, (square / rows).sqrt()))
}
