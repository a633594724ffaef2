//! Whether what was named lasts: a term must predict the part of the motion that it was not fitted on.
//!
//! Blocks of a periodic motion are copies of each other, and what fits one fits the next by chance as well as by
//! physics. So whole *regimes* are left out: a recording, a half of the time, a wavelength of a line. The gains are fitted
//! on the rest; over all regimes left out in turn, where the term would have to save something if it were real, it must
//! save squared error.
//!
//! A term that ends on a bound of its shape is a symptom of something else, and does not last either; nor does one whose size
//! the recording does not determine, nor a line that neighbouring wavelengths would explain nearly as well, nor a delay of a
//! part of the force.

use crate::findings::locate::{row_motion, row_times};
use crate::library::design_matrix::DesignMatrix;
use crate::library::term::TermKind;
use crate::regression::linear::{solve, solve_with_leverage};
use crate::search::applied_force::read_and_followed;
use crate::search::hypothesis::{Atom, Hypothesis};
use crate::search::joint::{Joint, at_end};
use crate::search::judgement::Search;
use crate::search::refine::FINE;
use crate::search::transport;
use friction::effects::Scale;
use signals::{Basis, dot, quantile};
use std::borrow::Borrow;
use std::cell::LazyCell;
use std::ops::Deref;

/// Rows of one kind of motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Regime {
    /// For a person: `the second half of the recording`.
    pub name: String,
    /// Whether each row is part of it.
    rows: Vec<bool>,
}

impl Regime {
    fn count(&self) -> usize {
        self.rows.iter().filter(|r| **r).count()
    }
}

/// A term that was named and taken back.
#[derive(Debug, Clone, PartialEq)]
pub struct Withdrawn {
    /// What it was.
    pub kind: TermKind,
    /// Where it fails, or the bound it ends on.
    pub regime: String,
    /// Root mean square error there without the term and with it, fitted on the rest.
    pub rms: (f64, f64),
}

/// Fewest rows of a regime, and of what is left for fitting.
const FEWEST: usize = 20;

/// Size of a term over its noise from which on a regime judges it.
const JUDGES: f64 = 5.0;

/// Fewest wavelengths on the stroke for a line to be one that repeats, where a bend explains as much.
const PERIODS: f64 = 3.0;

/// Share of what a line explains from which on a bend may be what it is: the rest is how six powers differ from a wave.
const SHARE_OF_BEND: f64 = 0.5;

/// Powers of the position that a bend has, in either direction.
const POWERS: i32 = 6;

/// Most wavelengths that are each left out in turn.
const MOST_PERIODS: usize = 12;

/// The regimes of a motion: each recording, or either half of the time where there is one only.
pub fn regimes(design: &DesignMatrix, names: &[String]) -> Vec<Regime> {
    let used = |r: usize| design.share[r] > 0.5;
    let rows = design.share.len();
    let all = design.used_rows();
    let time = row_times(design);
    let mut recording = Vec::with_capacity(rows);
    for t in &design.tracks {
        recording.extend(std::iter::repeat_n(t.raw.recording, t.row_count()));
    }
    let mut out = Vec::new();
    let mut add = |name: String, of: &dyn Fn(usize) -> bool| {
        let regime = Regime { name, rows: (0..rows).map(|r| used(r) && of(r)).collect() };
        let inside = regime.count();
        if inside >= FEWEST && all - inside >= FEWEST {
            out.push(regime);
        }
    };
    for (index, name) in names.iter().enumerate().filter(|_| names.len() > 1) {
        add(name.clone(), &|r| recording[r] == index);
    }
    if names.len() == 1 {
        let times: Vec<f64> = (0..rows).filter(|r| used(*r)).map(|r| time[r]).collect();
        let middle = quantile(&times, 0.5);
        add("the first half of the recording".into(), &|r| time[r] <= middle);
        add("the second half of the recording".into(), &|r| time[r] > middle);
    }
    out
}

/// The wavelengths of a line on the stroke, each a regime: a line comes again in every one of them.
fn periods(search: &Search, found: &Hypothesis, i: usize) -> Vec<Regime> {
    let term = &found.atoms[i].term;
    let Some(wave) = term.kind.about().wavelength().map(|axis| term.shape[axis]) else { return Vec::new() };
    let (low, high) = search.scales.stroke;
    let count = ((high - low) / wave).floor() as usize;
    let (position, _) = row_motion(search.design);
    let share = &search.design.share;
    (0..count.min(MOST_PERIODS))
        .map(|k| {
            let from = low + k as f64 * wave;
            let inside = |(x, s): (&f64, &f64)| *s > 0.5 && *x >= from && *x < from + wave;
            Regime {
                name: format!("wavelength {} of {count} on the stroke", k + 1),
                rows: position.iter().zip(share).map(inside).collect(),
            }
        })
        .collect()
}

/// Rows in use, in the regime or outside of it.
fn rows_of(design: &DesignMatrix, regime: &Regime, inside: bool) -> Vec<usize> {
    (0..design.share.len()).filter(|r| design.share[*r] > 0.5 && regime.rows[*r] == inside).collect()
}

/// Least squares over the rows `rest`; None where they say less of the rows `inside` than those say themselves, as of a way
/// back that is hardly among them.
fn solve_rest(
    columns: &[&[f64]],
    penalties: &[f64],
    y: &[f64],
    rest: &[usize],
    inside: &[usize],
) -> Option<Vec<f64>> {
    let gather = |of: &[f64], rows: &[usize]| rows.iter().map(|r| of[*r]).collect::<Vec<f64>>();
    let over = |rows: &[usize]| columns.iter().map(|c| gather(c, rows)).collect::<Vec<_>>();
    let (fitted, leverage) = solve_with_leverage(&over(rest), penalties, &gather(y, rest), &over(inside))?;
    (leverage <= 1.0).then_some(fitted)
}

/// Squared error over some rows.
fn error(columns: &[&[f64]], y: &[f64], coefficients: &[f64], rows: &[usize]) -> f64 {
    let left = |r: &usize| y[*r] - columns.iter().zip(coefficients).map(|(c, b)| c[*r] * b).sum::<f64>();
    rows.iter().map(|r| left(r).powi(2)).sum()
}

/// Squared error of a regime without a term and with it, the term's gains fitted on the rest; None where a term that is real
/// would not have to show. `columns` are the term's outside of the span of all others, `y` is what the others leave.
///
/// The others keep what the fit to all rows gives them: else each regime would judge how all of them extrapolate at once.
fn judge(
    design: &DesignMatrix,
    columns: &[&[f64]],
    penalties: &[f64],
    y: &[f64],
    all: &[f64],
    noise: f64,
    regime: &Regime,
) -> Option<(f64, f64)> {
    let (rest, inside) = (rows_of(design, regime, false), rows_of(design, regime, true));
    let none = vec![0.0; columns.len()];
    let power = |rows: &[usize]| {
        let said = |r: &usize| columns.iter().zip(all).map(|(c, b)| c[*r] * b).sum::<f64>();
        rows.iter().map(|r| said(r).powi(2)).sum::<f64>()
    };
    if power(&rest).min(power(&inside)) < JUDGES * JUDGES * noise * columns.len() as f64 {
        return None;
    }
    let fitted = solve_rest(columns, penalties, y, &rest, &inside)?;
    Some((error(columns, y, &none, &inside), error(columns, y, &fitted, &inside)))
}

impl Search<'_> {
    /// Takes back what does not last, the worst first, until everything that is left does: the hypothesis, the p value of
    /// each of its terms, and what was taken back.
    pub fn lasting(
        &self,
        (mut found, mut p): (Hypothesis, Vec<f64>),
        regimes: &[Regime],
    ) -> (Hypothesis, Vec<f64>, Vec<Withdrawn>) {
        let mut withdrawn = Vec::new();
        let Some(baseline) = Hypothesis::new(self.design, Vec::new()) else { return (found, p, withdrawn) };
        while let Some((i, why)) = worst(self, &found, regimes) {
            let mut atoms = found.atoms.clone();
            atoms.remove(i);
            let Some(without) = Hypothesis::new(self.design, atoms) else { break };
            withdrawn.push(why);
            (found, p) = self.prune(self.refine(without, FINE), baseline.fit.heldout_sum());
        }
        (found, p, withdrawn)
    }
}

/// Squared error of each regime that can judge, without some columns and with them, their coefficients fitted on the
/// rest. `others` is the span of everything else.
pub fn left_out_errors<'r>(
    design: &DesignMatrix,
    others: &Basis,
    columns: &[impl Borrow<Vec<f64>>],
    penalties: &[f64],
    noise: f64,
    regimes: &'r [Regime],
) -> Vec<(&'r Regime, (f64, f64))> {
    let own: Vec<Vec<f64>> = columns.iter().map(|c| others.project_out(c.borrow())).collect();
    let own: Vec<&[f64]> = own.iter().map(Vec::as_slice).collect();
    let y = others.project_out(&design.y);
    let Some(all) = solve(&own, penalties, &y) else { return Vec::new() };
    regimes.iter().filter_map(|r| Some((r, judge(design, &own, penalties, &y, &all, noise, r)?))).collect()
}

/// The term that lasts least, none where all do.
fn worst(search: &Search, found: &Hypothesis, regimes: &[Regime]) -> Option<(usize, Withdrawn)> {
    let forces = LazyCell::new(|| read_and_followed(search, found));
    let bound = (0..found.atoms.len()).find_map(|i| {
        let kind = found.atoms[i].term.kind;
        let symptom = || {
            no_line(search, found, i)
                .or_else(|| part_of_the_force(search, found, i))
                .or_else(|| another_force(kind, &forces))
        };
        let regime = on_bound(search, found, i).or_else(symptom)?;
        Some((i, Withdrawn { kind, regime, rms: (f64::NAN, f64::NAN) }))
    });
    if let Some(failed) = bound.or_else(|| of_no_size(search, found)) {
        return Some(failed);
    }
    let design = search.design;
    let noise = noise(design, found);
    let mut failed: Option<(f64, usize, Withdrawn)> = None;
    for i in 0..found.atoms.len() {
        let mut others = found.atoms.clone();
        others.remove(i);
        let basis = Basis::of(&Hypothesis::columns(design, &others));
        let mut note = |name: &str, rows: usize, (without, with): (f64, f64)| {
            let ratio = with / without;
            if failed.as_ref().is_none_or(|f| ratio > f.0) {
                let rms = |sum: f64| (sum / rows.max(1) as f64).sqrt();
                let kind = found.atoms[i].term.kind;
                let withdrawn = Withdrawn { kind, regime: name.into(), rms: (rms(without), rms(with)) };
                failed = Some((ratio, i, withdrawn));
            }
        };
        // one regime may fail by what is not in the model; all of them together decide
        for parts in [regimes, &periods(search, found, i)] {
            let judged = left_out_errors(design, &basis, &found.atoms[i].columns, &[], noise, parts);
            let sum = judged.iter().fold((0.0, 0.0), |s, (_, e)| (s.0 + e.0, s.1 + e.1));
            let worst = judged.iter().max_by(|a, b| (a.1.1 - a.1.0).total_cmp(&(b.1.1 - b.1.0)));
            if let Some((regime, errors)) = worst.filter(|_| sum.1 >= sum.0) {
                note(&regime.name, regime.count(), *errors);
            }
        }
    }
    failed.map(|(_, i, why)| (i, why))
}

/// Standard errors from which on a gain is known not to be zero.
const SIZED: f64 = 2.0;

/// The term of which no gain is known to differ from zero, its shape and all other terms being free: another size would
/// explain as much, with another shape.
fn of_no_size(search: &Search, found: &Hypothesis) -> Option<(usize, Withdrawn)> {
    let joint = Joint::of(search, found);
    let known = |i: usize| {
        let from = found.offset(search.design, i);
        let gains = found.coefficients(search.design, i).iter().enumerate();
        gains.map(|(k, c)| c.abs() / joint.gain(from + k)).fold(0.0, f64::max)
    };
    let (size, i) = (0..found.atoms.len()).map(|i| (known(i), i)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let regime = "its size is not known: another shape explains as much with none of it".into();
    let kind = found.atoms[i].term.kind;
    (size < SIZED).then_some((i, Withdrawn { kind, regime, rms: (f64::NAN, f64::NAN) }))
}

/// Cost of a step away from a bound over its standard deviation from which on the recording pushes against it.
const PUSHED: f64 = 2.0;

/// Step from a bound, as a share of the range of a shape parameter.
const INWARD: f64 = 0.1;

/// Whether the recording pushes a shape parameter against the end where it stands: a step away from it costs surely more
/// than noise would. Otherwise it only does not matter, as the place of an end of the stroke that is never reached.
fn is_pushed(search: &Search, found: &Hypothesis, i: usize, axis: usize) -> bool {
    let design = search.design;
    let (low, high, log) = search.scales.range(&found.atoms[i].term.kind.shape()[axis]);
    let from = if log { |x: f64| x.ln() } else { |x: f64| x };
    let to = if log { |x: f64| x.exp() } else { |x: f64| x };
    let here = from(found.atoms[i].term.shape[axis]);
    let way = if here - from(low) < from(high) - here { 1.0 } else { -1.0 };
    let mut atoms = found.atoms.clone();
    atoms[i].term.shape[axis] = to(here + way * INWARD * (from(high) - from(low)));
    atoms[i] = Atom::new(design, &search.catalogue.baseline, atoms[i].term);
    let Some(inward) = Hypothesis::new(design, atoms) else { return false };
    let squared = |h: &Hypothesis| dot(&h.fit.residual, &h.fit.residual);
    squared(&inward) - squared(found) > PUSHED * PUSHED * noise(design, found)
}

/// Variance of the sum of neighbouring rows, over their number: rows follow each other and err alike.
fn noise(design: &DesignMatrix, found: &Hypothesis) -> f64 {
    let used = design.used_rows().max(1) as f64;
    let apart = (design.share.len() as f64 / design.blocks.len().max(1) as f64).clamp(1.0, 10.0);
    dot(&found.fit.residual, &found.fit.residual) / used * apart
}

/// Why the shape of term `i` says nothing: it stands at an end of what was tried, or a line does not come again.
fn on_bound(search: &Search, found: &Hypothesis, i: usize) -> Option<String> {
    let atom = &found.atoms[i];
    for (axis, parameter) in atom.term.kind.shape().iter().enumerate() {
        if parameter.scale == Scale::Wavelength {
            let (low, high) = search.scales.stroke;
            if atom.term.shape[axis] * PERIODS > high - low && is_a_bend(search, found, i) {
                return Some("fewer than three wavelengths on the stroke".into());
            }
            if path_that_passes(search, atom.term.shape[axis]) < PASSING {
                return Some("too fine for the filter on most of the path".into());
            }
        } else if at_end(search, atom, axis) && is_pushed(search, found, i, axis) {
            return Some(format!("{} ends on a bound", parameter.name));
        }
    }
    None
}

/// Share of the path on which a line has to pass the filter. Where it is less, it acts at the few slow moments beside reversals, where any
/// friction at low speed looks like it.
const PASSING: f64 = 0.3;

/// Share of the path on which a line over the position is slow enough in time for the filter.
fn path_that_passes(search: &Search, wavelength: f64) -> f64 {
    let (mut passing, mut all) = (0.0, 0.0);
    for t in &search.design.tracks {
        for (v, mask) in t.v.iter().zip(&t.mask) {
            let way = mask * v.abs() * t.raw.dt;
            all += way;
            passing += if v.abs() <= wavelength * t.filter.cutoff() { way } else { 0.0 };
        }
    }
    if all > 0.0 { passing / all } else { 1.0 }
}

/// Whether a curve of the position explains most of what the line `i` does: any bend looks like a piece of a wave. A wave of the encoder
/// is none: it shows with the square of the speed.
fn is_a_bend(search: &Search, found: &Hypothesis, i: usize) -> bool {
    let design = search.design;
    let mut others = found.atoms.clone();
    others.remove(i);
    let (low, high) = search.scales.stroke;
    let mut columns = Hypothesis::columns(design, &others);
    let around = Basis::of(&columns);
    let own = Basis::of(&found.atoms[i].outside(&around)).captured(&around.project_out(&design.y));
    let bends: Vec<Vec<f64>> = (1..=POWERS)
        .flat_map(|power| {
            let over = |x: f64| ((2.0 * x - low - high) / (high - low)).powi(power);
            [false, true].map(|flips| {
                design.rows(|t| {
                    let way = |i: usize| if flips { t.sign[i] } else { 1.0 };
                    t.pass(&(0..t.len()).map(|i| way(i) * over(t.x[i])).collect::<Vec<_>>())
                })
            })
        })
        .collect();
    let squared = |columns: &[&[f64]]| {
        let left = Basis::of(columns).project_out(&design.y);
        dot(&left, &left)
    };
    let before = squared(&columns);
    columns.extend(bends.iter().map(Vec::as_slice));
    before - squared(&columns) >= SHARE_OF_BEND * own
}

/// Error that a line explains over what its neighbours explain of the rest from which on it is one. The best of all
/// wavelengths explains about ten times as much of white noise as they do, those of a machine at half the noise sixty times and
/// more.
const STANDS_OUT: f64 = 25.0;

/// Distances of the neighbours in wavenumber, in cycles on the stroke: beyond what the line itself leaks there.
const NEIGHBOURS: [f64; 8] = [-4.5, -3.5, -2.5, -1.5, 1.5, 2.5, 3.5, 4.5];

/// Whether term `i` is a wavelength among many that explain about as much: the error then follows the position, but does not
/// repeat along it.
fn no_line(search: &Search, found: &Hypothesis, i: usize) -> Option<String> {
    let atom = &found.atoms[i];
    let wave = atom.term.kind.about().wavelength()?;
    let (low, high) = search.scales.stroke;
    let around = Basis::of(&Hypothesis::columns(search.design, &found.atoms));
    let neighbours: Vec<f64> = NEIGHBOURS
        .iter()
        .map(|m| atom.term.shape[wave].recip() + m / (high - low))
        .filter(|wavenumber| *wavenumber * (high - low) >= 1.0)
        .filter_map(|wavenumber| {
            let mut term = atom.term;
            term.shape[wave] = wavenumber.recip();
            let other = Atom::new(search.design, &search.catalogue.baseline, term);
            let count = other.columns.len();
            (count > 0)
                .then(|| Basis::of(&other.outside(&around)).captured(&found.fit.residual) / count as f64)
        })
        .collect();
    let mut others = found.atoms.clone();
    others.remove(i);
    let others = Basis::of(&Hypothesis::columns(search.design, &others));
    let own = Basis::of(&atom.outside(&others)).captured(&others.project_out(&search.design.y));
    let own = own / atom.columns.len() as f64;
    let mean = neighbours.iter().sum::<f64>() / neighbours.len().max(1) as f64;
    (own < STANDS_OUT * mean).then(|| "neighbouring wavelengths explain nearly as much of the rest".into())
}

/// Share of the force by which what moves in time may fall short of all of it: the rest of the model is not exact.
const SHORT: f64 = 0.15;

/// Standard errors by which it has to.
const SURELY: f64 = 2.0;

/// Whether term `i` moves a part of the force in time, where a delay or a lag of a channel moves all of it: then a part of the
/// physics reacts late.
fn part_of_the_force(search: &Search, found: &Hypothesis, i: usize) -> Option<String> {
    found.atoms[i].term.kind.moves_in_time().then_some(())?;
    let (share, std) = transport::share(search, found, i)?;
    (share < 1.0 - SHORT && share + SURELY * std < 1.0)
        .then(|| format!("{:.0} % of the force moves in time, not all of it", 100.0 * share.max(0.0)))
}

/// Error of the force that follows from a model over that of the force that its terms read, from which on it is worse.
const WORSE: f64 = 1.2;

/// Whether an effect reads the applied force, and the model makes another one, whose error `forces` has beside that of the one read: a
/// friction that takes nearly all of the force for itself multiplies every error of the rest.
fn another_force(kind: TermKind, forces: &impl Deref<Target = (f64, f64)>) -> Option<String> {
    (matches!(kind, TermKind::Force(_)) && kind.reads_force()).then_some(())?;
    let (read, followed) = **forces;
    (followed > WORSE * read).then(|| {
        format!("the force that follows is {:.1} times as far off as the one that it reads", followed / read)
    })
}

/// Root mean square error of the first `baseline` columns and of `found` in the recording or the half of the time left out in
/// which `found` does worst against them, all gains fitted on the rest.
pub fn left_out(
    search: &Search,
    found: &Hypothesis,
    regimes: &[Regime],
    baseline: usize,
) -> Option<(String, f64, f64)> {
    let design = search.design;
    let (columns, penalties) = (found.lasting_columns(design), found.lasting_penalties(design));
    let of = |regime: &Regime| {
        let (rest, inside) = (rows_of(design, regime, false), rows_of(design, regime, true));
        let rms = |columns: &[&[f64]]| {
            let penalties = &penalties[..columns.len()];
            let fitted = solve_rest(columns, penalties, &design.y, &rest, &inside)?;
            Some((error(columns, &design.y, &fitted, &inside) / inside.len() as f64).sqrt())
        };
        Some((regime.name.clone(), rms(&columns[..baseline])?, rms(&columns)?))
    };
    let ratio = |x: &(String, f64, f64)| x.2 / x.1;
    regimes.iter().filter_map(of).max_by(|a, b| ratio(a).total_cmp(&ratio(b)))
}
