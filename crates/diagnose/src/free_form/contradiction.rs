//! Names that a free form contradicts: an effect that adds nothing beside the curve was a part of the curve.

use crate::free_form::candidate::Library;
use crate::free_form::describe::{Described, LEAVES, describe};
use crate::library::design_matrix::DesignMatrix;
use crate::library::term::{Term, TermKind};
use crate::options::{Interrupted, Watch};
use crate::regression::linear::Fit;
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::judgement::Search;
use crate::search::lasting::Regime;
use friction::effects::Quantity;
use signals::subtract_scaled;

/// Share of what names leave above the floor that as many free forms have to explain to contradict them.
const BETTER: f64 = 0.25;

/// Relative increase of the held-out error up to which fewer free forms are as good as names and forms together.
const AS_GOOD: f64 = 0.02;

/// The same as a share of what names and forms gain, up to a share of what noise alone leaves: beside a weight that is most of the
/// force, friction is a small part of the gain and several floors.
const OF_GAIN: f64 = 0.005;
const OF_FLOOR: f64 = 0.5;

/// Share of its gain beside the free forms that an effect also reaches without them, unless it only stands in for a form.
const ITS_OWN: f64 = 0.5;

/// Most free directions of a form that takes the place of several names because it is one: a finer curve follows any of them.
const COARSE: usize = 22;

/// Most numbers of names that a curve does not take the place of because it is one: it needs as many itself.
const SHORT: usize = 3;

/// Names and forms beyond which a simpler description is looked for over a derived acceleration, too.
const MANY: usize = 2;

/// Share of the whole work that is done where what has no name is described.
pub const DESCRIBED: f32 = 0.8;

/// Confirmed names, free forms, and the names that the free forms contradict.
pub struct Resolved {
    pub found: Hypothesis,
    pub described: Described,
    pub kin: Vec<TermKind>,
    /// Family-wise p of each name that was found beside free forms.
    pub beside: Vec<(Term, f64)>,
}

impl Resolved {
    fn of(found: &Hypothesis, described: Described) -> Self {
        Self { found: found.clone(), described, kin: Vec::new(), beside: Vec::new() }
    }
}

/// Describes what `found` leaves, and takes back every name that the description contradicts.
pub fn resolve(
    search: &Search,
    found: &Hypothesis,
    regimes: &[Regime],
    baseline: &Hypothesis,
    watch: Watch<'_>,
) -> Result<Resolved, Interrupted> {
    let mut library = Library::new(search.design);
    let mut described = describe(search, &library, found, regimes);
    let named = described.fit.heldout_sum();
    let much = named > LEAVES * search.floor;
    if found.atoms.is_empty() {
        if much && library.widen() {
            let wider = describe(search, &library, found, regimes);
            if described.terms.is_empty() || is_better(search, &described.fit, &wider.fit) {
                described = wider;
            }
        }
        return named_beside(search, &library, regimes, Resolved::of(found, described), watch);
    }
    if found.atoms.len() == 1 && described.terms.is_empty() && !much {
        return Ok(Resolved::of(found, described));
    }
    let names = found.atoms.len() + described.terms.len();
    let of_names: usize = found.atoms.iter().map(Atom::parameters).sum();
    let numbers = of_names + described.terms.iter().map(|t| t.freedom).sum::<usize>();
    let of_gain = OF_GAIN * (baseline.fit.heldout_sum() - named);
    let as_good = named + (AS_GOOD * named).max(of_gain.min(OF_FLOOR * search.floor));
    let contradicts = |other: &(Hypothesis, Described)| {
        let (kept, alone) = other;
        let (free, count) = (alone.fit.heldout_sum(), kept.atoms.len() + alone.terms.len());
        let coarse = alone.terms.iter().all(|t| t.freedom <= COARSE);
        let fewer = count < names && numbers > SHORT && coarse && free < as_good;
        let as_many = count == names && is_better(search, &described.fit, &alone.fit);
        let gains = || search.gains_surely(&described.fit, &alone.fit);
        !alone.terms.is_empty() && (fewer || as_many || gains())
    };
    let contradiction = |library: &Library, kept: &Hypothesis| {
        Some((kept.clone(), describe(search, library, kept, regimes))).filter(contradicts)
    };
    let elsewhere = not_over_position(search.design, found);
    let kept = std::iter::once(baseline).chain(&elsewhere);
    let mut others: Vec<_> = kept.filter_map(|kept| contradiction(&library, kept)).collect();
    let heldout = |other: &(Hypothesis, Described)| other.1.fit.heldout_sum();
    let least = others.iter().map(heldout).reduce(f64::min).unwrap_or(named);
    if (least > LEAVES * search.floor || names > MANY) && library.widen() {
        others.extend(contradiction(&library, baseline));
    }
    let resolved = match others.into_iter().min_by(|a, b| heldout(a).total_cmp(&heldout(b))) {
        Some((kept, alone)) => restored(search, found, &kept, alone),
        None => Resolved::of(found, described),
    };
    let resolved = needless(search, resolved);
    named_beside(search, &library, regimes, resolved, watch)
}

/// Searches for named effects in what the curves leave, then describes the rest anew: beside a large error a small effect goes
/// unnoticed, and curves are fitted in its place. Keeps the result if it leaves much less.
fn named_beside(
    search: &Search,
    library: &Library,
    regimes: &[Regime],
    now: Resolved,
    watch: Watch<'_>,
) -> Result<Resolved, Interrupted> {
    if now.described.fit.heldout_sum() < LEAVES * search.floor {
        return Ok(now);
    }
    // as far as the work was before
    let watch: Watch<'_> = &|_, what| watch(DESCRIBED, what);
    let mut best: Option<Resolved> = None;
    let (mut design, mut noisy) = (search.design.clone(), search.noisy.clone());
    let named = Hypothesis::columns(search.design, &now.found.atoms).len();
    let mut of_curves = now.described.fit.coefficients[named..].iter();
    for term in &now.described.terms {
        for (column, gain) in term.columns.iter().zip(&mut of_curves) {
            subtract_scaled(&mut design.y, *gain, column);
            subtract_scaled(&mut noisy.y, *gain, column);
        }
        let rest = Search { design: &design, noisy: &noisy, ..*search };
        let Some(empty) = Hypothesis::new(&design, Vec::new()) else { continue };
        let Some(named) = rest.run(empty, watch)? else { continue };
        let (named, p, _) = rest.lasting(named, regimes);
        let beside = named.atoms.iter().map(|a| a.term).zip(p).collect();
        let Some(found) = Hypothesis::new(search.design, named.atoms).filter(|h| !h.atoms.is_empty()) else {
            continue;
        };
        let described = describe(search, library, &found, regimes);
        let least = best.as_ref().map_or(&now.described.fit, |b| &b.described.fit);
        if is_better(search, least, &described.fit) && search.physical(&described.beside(&found)) {
            let kin = now.kin.iter().copied().filter(|kind| !found.has(*kind)).collect();
            best = Some(Resolved { kin, beside, ..Resolved::of(&found, described) });
        }
    }
    Ok(best.map_or(now, |best| needless(search, best)))
}

/// The names that are not over the position, where there are others: a curve over the position contradicts those, whatever else
/// is there.
fn not_over_position(design: &DesignMatrix, found: &Hypothesis) -> Option<Hypothesis> {
    let elsewhere = |a: &&Atom| !a.term.kind.about().reads(Quantity::Position);
    let atoms: Vec<Atom> = found.atoms.iter().filter(elsewhere).cloned().collect();
    let some = !atoms.is_empty() && atoms.len() < found.atoms.len();
    some.then(|| Hypothesis::new(design, atoms)).flatten()
}

/// Whether the second of two fits explains so much of what the first leaves that the first is wrong.
fn is_better(search: &Search, first: &Fit, second: &Fit) -> bool {
    let (first, second) = (first.heldout_sum(), second.heldout_sum());
    first - second > BETTER * (first - search.floor)
}

/// Puts an effect in the place of each free form that it explains as well.
fn restored(search: &Search, found: &Hypothesis, kept: &Hypothesis, alone: Described) -> Resolved {
    let mut now = Resolved::of(kept, alone);
    let mut left: Vec<Atom> = found.atoms.iter().filter(|a| !kept.has(a.term.kind)).cloned().collect();
    loop {
        let place = |i: usize, c: usize| {
            let atoms = now.found.atoms.iter().chain([&left[i]]).cloned().collect();
            let with = Hypothesis::new(search.design, atoms)?;
            let fitted = now.described.without(search, &with, Some(c))?;
            let worse = search.gains_surely(&fitted.fit, &now.described.fit)
                || fitted.fit.heldout_sum() > LEAVES * search.floor
                    && is_better(search, &fitted.fit, &now.described.fit);
            (!worse && search.physical(&with)).then(|| (fitted.fit.heldout_sum(), i, with, fitted))
        };
        let pairs = (0..left.len()).flat_map(|i| (0..now.described.terms.len()).map(move |c| (i, c)));
        let best = pairs.filter_map(|(i, c)| place(i, c)).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, i, with, fitted)) = best else { break };
        left.remove(i);
        (now.found, now.described) = (with, fitted);
    }
    now.kin = left.iter().map(|a| a.term.kind).collect();
    now
}

/// Takes back, one after the other, every effect that predicts nothing beside the free forms, or nothing without them: then it
/// stands for what a form is too coarse for. Without them the error is larger and may hide a real gain, so a gain about as
/// large as beside them also counts, and one that was found beside them needs no other.
fn needless(search: &Search, mut now: Resolved) -> Resolved {
    while !now.described.terms.is_empty() {
        let without = |i: usize| {
            let mut atoms = now.found.atoms.clone();
            atoms.remove(i);
            let fewer = Hypothesis::new(search.design, atoms)?;
            let fitted = now.described.without(search, &fewer, None)?;
            let gain = |without: &Fit, with: &Fit| without.heldout_sum() - with.heldout_sum();
            let (before, after) = (&fitted.fit, &now.described.fit);
            let as_much = || gain(&fewer.fit, &now.found.fit) > ITS_OWN * gain(before, after);
            let gains = search.gains_surely(before, after);
            let needed = if now.beside.iter().any(|(term, _)| *term == now.found.atoms[i].term) {
                gains || is_better(search, before, after)
            } else {
                gains && (search.gains_surely(&fewer.fit, &now.found.fit) || as_much())
            };
            (!needed).then(|| (fitted.fit.heldout_sum(), i, fewer, fitted))
        };
        let best = (0..now.found.atoms.len()).filter_map(without).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, i, fewer, fitted)) = best else { break };
        now.kin.push(now.found.atoms[i].term.kind);
        (now.found, now.described) = (fewer, fitted);
    }
    now
}
