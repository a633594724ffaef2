//! A free form as an entry of what is missing.

use crate::findings::words::short;
use crate::free_form::change::Change;
use crate::free_form::describe::Gain;
use crate::free_form::formula::looks_like;
use crate::free_form::term::FreeTerm;
use crate::result::{FreeCurve, FreeFormFinding, Location, LooksLike, Missing, Quantity};
use friction::effects::{Describe, Unnamed};
use friction::{Coordinate, Dimension, Factor, Geometry};
use std::collections::BTreeMap;

/// What in a machine usually comes and goes.
const SWITCHED: &str =
    "something beside the machine that is switched, or that touches: a fan, a brake, a heater, a hand";

/// Dimension of a coordinate.
fn dimension(of: Coordinate) -> Dimension {
    match of {
        Coordinate::Position | Coordinate::DistanceSinceReversal => Dimension::LENGTH,
        Coordinate::Slid | Coordinate::Moved => Dimension::LENGTH,
        Coordinate::Velocity | Coordinate::Speed => Dimension::VELOCITY,
        Coordinate::Acceleration => Dimension::ACCELERATION,
        Coordinate::Time | Coordinate::TimeSinceReversal => Dimension::TIME,
    }
}

/// Name of a coordinate in a sentence.
fn words(of: Coordinate) -> String {
    match of {
        Coordinate::Slid => "the distance slid in the last moments".into(),
        Coordinate::Moved => "the displacement in the last moments".into(),
        Coordinate::Speed => "the speed".into(),
        Coordinate::DistanceSinceReversal | Coordinate::TimeSinceReversal => {
            format!("the {}", of.id().replace("_since_", " since the last "))
        }
        other => other.id().into(),
    }
}

/// What a curve with this factor is.
fn thing(times: Factor) -> &'static str {
    match times {
        Factor::One => "a force",
        Factor::Direction => "friction",
        Factor::Velocity => "a viscous coefficient",
    }
}

/// The factor in an equation.
fn prefix(times: Factor) -> &'static str {
    match times {
        Factor::One => "",
        Factor::Direction => "sgn(v)*",
        Factor::Velocity => "v*",
    }
}

/// The move that separates a form's coordinate from the others.
fn experiment(term: &FreeTerm) -> String {
    let has = |c: Coordinate| term.form.reads(c);
    if Change::of(term).is_some() {
        "find out what happened at that moment, and repeat the move with it and without it"
    } else if has(Coordinate::Time) {
        "repeat the same move: an effect of the time since the start begins again, an effect of the time of day does not"
    } else if has(Coordinate::Slid) {
        "slide at one speed, rest for a while, slide again: what was slid fades, a position stays"
    } else if has(Coordinate::Moved) {
        "move, hold the new position and watch the force: what relaxes falls, a spring stays"
    } else if has(Coordinate::DistanceSinceReversal) || has(Coordinate::TimeSinceReversal) {
        "reverse after strokes of different length and at different speeds"
    } else if has(Coordinate::Position) && (has(Coordinate::Velocity) || term.form.times != Factor::One) {
        "cross the same positions at three speeds, in both directions"
    } else if has(Coordinate::Position) {
        "move through the same positions at another speed and from another start"
    } else {
        "reach the same speeds at other positions and with other accelerations"
    }
    .into()
}

/// What a free form says; `rows` are those behind the squares of `gain`.
pub fn missing(term: &FreeTerm, gain: &Gain, rows: f64, kin: &[&str], geometry: Geometry) -> Missing {
    let form = &term.form;
    let force = Dimension::FORCE.unit(geometry).to_string();
    let unit_of = |c: Coordinate| dimension(c).unit(geometry).to_string();
    let unit = match form.times {
        Factor::Velocity => Dimension::FORCE.per(Dimension::VELOCITY).unit(geometry).to_string(),
        _ => force,
    };
    let across = form.across.map(|(c, _)| c);
    let (low, high) =
        form.values().iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let on = match across {
        Some(c) => format!("{} and {} together", words(form.over), words(c)),
        None => words(form.over),
    };
    let (what, times) = (thing(form.times), prefix(form.times));
    let formula = looks_like(term);
    let looks_like = formula.map(|f| LooksLike {
        formula: f.formula,
        parameters: f
            .shape
            .into_iter()
            .map(|(name, value, placed)| {
                let unit = if placed { unit_of(form.over) } else { String::new() };
                (name, Quantity { value, std: f64::NAN, unit })
            })
            .chain([("gain".to_string(), Quantity { value: f.gain.0, std: f.gain.1, unit: unit.clone() })])
            .collect(),
        runner_up: f.runner_up,
        made_by: f.made_by.into(),
    });
    let says = match Change::of(term) {
        Some(change) => format!(
            "{what} that changes by {} {unit}, {} s after the start",
            short(change.size()),
            short(change.at)
        ),
        None => format!("{what} over {on}, from {} to {} {unit}", short(low), short(high)),
    };
    let to_rms = |sum: f64| (sum / rows).sqrt();
    let coordinates: Vec<String> =
        std::iter::once(form.over).chain(across).map(|c| c.id().to_string()).collect();
    Missing {
        effect: Unnamed::ABOUT.id.into(),
        says,
        equation: format!("{times}f({})", coordinates.join(", ")),
        parameters: BTreeMap::new(),
        rms_heldout_before: to_rms(gain.before),
        rms_heldout_after: to_rms(gain.after),
        gain_ci95: gain.interval,
        p: gain.p,
        indistinguishable_from: Vec::new(),
        experiment: experiment(term),
        free_form: Some(FreeFormFinding {
            units: std::iter::once(form.over).chain(across).map(unit_of).collect(),
            coordinates,
            curve: FreeCurve {
                times: form.times.id().into(),
                memory_s: form.over.fades().then_some(form.memory),
                period_s: None,
                knots: form.knots.places().to_vec(),
                knots_across: form.across.map(|(_, k)| k.places().to_vec()).unwrap_or_default(),
                values: form.values().to_vec(),
                band: term.std.iter().map(|s| 1.96 * s).collect(),
                unit,
            },
            looks_like,
            kin: kin.iter().map(|k| (*k).to_string()).collect(),
        }),
    }
}

/// What several changes of one thing say together, with the largest gain of them, and between which moments they are; `rows` are
/// those behind the squares of the gains. None of other forms.
pub fn switching(
    terms: &[FreeTerm],
    gains: &[Gain],
    rows: f64,
    geometry: Geometry,
) -> Option<(Missing, Location)> {
    let first = terms.first()?;
    let whole = |a: Gain, b: &Gain| Gain { before: a.before.max(b.before), after: a.after.min(b.after), ..a };
    let gain = gains.iter().fold(*gains.first()?, whole);
    let times = first.form.times;
    let one_thing = terms.len() > 1 && terms.iter().all(|t| t.form.times == times);
    let changes: Vec<Change> = terms.iter().filter(|_| one_thing).map(Change::of).collect::<Option<_>>()?;
    let (from, to) = (changes.first()?.at, changes.last()?.at);
    let mut one = missing(first, &gain, rows, &[], geometry);
    let finding = one.free_form.as_mut()?;
    let unit = finding.curve.unit.clone();
    let seconds = Dimension::TIME.unit(geometry).to_string();
    let list: Vec<String> = changes
        .iter()
        .map(|c| {
            let sign = if c.size() > 0.0 { "+" } else { "" };
            format!("{sign}{} {unit} at {} s", short(c.size()), short(c.at))
        })
        .collect();
    let knots: Vec<f64> = terms.iter().flat_map(|t| t.form.knots.places().to_vec()).collect();
    let level =
        |time: &f64| -> f64 { changes.iter().map(|c| if *time < c.at { c.before } else { c.after }).sum() };
    let largest = *changes.iter().max_by(|a, b| a.size().abs().total_cmp(&b.size().abs()))?;
    let gain_of_all = Quantity { value: largest.size().abs(), std: largest.std, unit: unit.clone() };
    finding.looks_like = Some(LooksLike {
        formula: "sum(share_i*step(time - t_i))".into(),
        parameters: (1..)
            .zip(&changes)
            .flat_map(|(i, c)| {
                let of_largest = |x: f64| x / largest.size().abs();
                let share =
                    Quantity { value: of_largest(c.size()), std: of_largest(c.std), unit: String::new() };
                let moment = Quantity { value: c.at, std: f64::NAN, unit: seconds.clone() };
                [(format!("share_{i}"), share), (format!("t_{i}"), moment)]
            })
            .chain([("gain".to_string(), gain_of_all)])
            .collect(),
        runner_up: None,
        made_by: SWITCHED.into(),
    });
    finding.curve.values = knots.iter().map(level).collect();
    finding.curve.band = changes.iter().flat_map(|c| [1.96 * c.std; 2]).collect();
    finding.curve.knots = knots;
    let grows = |sign: f64| changes.iter().all(|c| sign * c.size() > 0.0);
    let how = if grows(1.0) || grows(-1.0) { "changes step by step" } else { "comes and goes" };
    let location = Location {
        coordinate: Coordinate::Time.id().into(),
        from,
        to,
        unit: seconds.clone(),
        share_of_mismatch: (1.0 - gain.after / gain.before).clamp(0.0, 1.0),
        p: gain.p,
    };
    let missing = Missing {
        says: format!("{} that {how}: {}", thing(times), list.join(", ")),
        experiment: "find out what was switched at those moments, and record its state as a further column"
            .into(),
        ..one
    };
    Some((missing, location))
}
