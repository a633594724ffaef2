//! Answers against labels: opened only when every answer is written.

use crate::error::{Error, Result};
use crate::hidden::find;
use crate::seal::{Label, Places};
use crate::sensors::DECOYS;
use friction::{Karnopp, Law};
use identify::Model;
use serde_json::Value;
use signals::{Geometry, ReadOptions, Recording};
use std::path::Path;

/// How one case went.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub(crate) struct Outcome {
    /// Number of the case.
    pub case: usize,
    /// `null`, `single`, `pair`, `never`, `decoy` or `unreached`.
    pub kind: String,
    /// What was hidden, with `+` between two; the decoy's name; `nothing`.
    pub hidden: String,
    /// Times the noise, as asked for.
    pub strength: f64,
    /// The verdict.
    pub verdict: String,
    /// What was named, first first.
    pub named: Vec<String>,
    /// What the first was said to be indistinguishable from.
    pub equal: Vec<String>,
    /// The hidden effect is first.
    pub first: bool,
    /// It is first, or reported as indistinguishable from the first, or nothing is named and the report says that the recording is blind to it.
    pub told: bool,
    /// Everything hidden is named.
    pub all: bool,
    /// Something was named that is not there.
    pub false_alarm: bool,
    /// The effect, or why it cannot be seen, is among what the recording is blind to.
    pub blind: bool,
    /// A coordinate over which the effect shows is among the first three coordinates located; none where none is expected.
    pub located: Option<bool>,
    /// Whether what was hidden shows over one of the first three coordinates located; none where nothing was located.
    pub placed: Option<bool>,
    /// What was hidden shows over a coordinate of the motion.
    pub has_a_place: bool,
    /// Mean relative error of the effect's parameters.
    pub parameter_error: Option<f64>,
    /// Parameters of the effect, and how many of their 95 % intervals hold the truth.
    pub parameters: (usize, usize),
    /// The same for the baseline's parameters, fitted with what was named.
    pub baseline: (usize, usize),
    /// Whether the 95 % interval of the held-out gain, widened for the noise of a second record, holds that record's gain.
    pub gain_covered: Option<bool>,
    /// Share of the squared error of the frozen baseline on the truth of a new motion that the frozen model explains.
    pub explained: Option<f64>,
}

/// Scores one case.
///
/// # Errors
/// A file of the proof that is missing or damaged.
pub(crate) fn score(places: &Places, case: usize) -> Result<Outcome> {
    let label: Label = serde_json::from_value(json(&places.label(case))?)?;
    let answer = json(&places.answer(case, "json"))?;
    let list = |value: &Value, field: &str, name: &str| -> Vec<String> {
        let entries = value[field].as_array().map(Vec::as_slice).unwrap_or_default();
        entries.iter().filter_map(|m| m[name].as_str().or(m.as_str())).map(String::from).collect()
    };
    let entries = entries(&answer);
    let named: Vec<String> = entries.iter().filter_map(|m| m["effect"].as_str()).map(String::from).collect();
    let leading = entries.first().copied().unwrap_or(&Value::Null);
    let equal = list(leading, "indistinguishable_from", "effect");
    let blind = list(&answer, "blind_to", "effect");
    let right =
        |hidden: &str, said: &str| said == hidden || find(hidden).is_some_and(|k| k.also.contains(&said));
    let hidden: Vec<&str> = label.concealed.iter().map(|c| c.effect.as_str()).collect();
    let any = |said: &str| hidden.iter().any(|h| right(h, said));
    let allowed = DECOYS.iter().find(|d| d.id == label.decoy).map_or(&[][..], |d| d.allowed);
    let unseen = named.is_empty() && hidden.iter().any(|h| blind.iter().any(|b| b == h));
    let first = named.first().is_some_and(|n| any(n));
    let mut out = Outcome {
        case,
        hidden: match (hidden.is_empty(), label.decoy.as_str()) {
            (true, "") => "nothing".into(),
            (true, decoy) => decoy.into(),
            _ => hidden.join("+"),
        },
        strength: label.concealed.first().map_or(0.0, |c| c.strength),
        verdict: answer["verdict"].as_str().unwrap_or_default().into(),
        first,
        told: first || unseen || equal.iter().any(|e| any(e)),
        all: hidden.iter().all(|h| named.iter().any(|n| right(h, n))),
        false_alarm: named.iter().any(|n| !any(n) && !allowed.contains(&n.as_str())),
        blind: hidden.iter().any(|h| blind.iter().any(|b| b == h)),
        ..Outcome::default()
    };
    let expected: Vec<&str> =
        hidden.iter().filter_map(|h| find(h)).flat_map(|k| k.shows_over).copied().collect();
    let mut over = list(&answer, "location", "coordinate");
    over.dedup();
    // a repaired channel is found by comparing channels and has no location
    let of_channel = !named.is_empty() && answer["missing"].as_array().is_none_or(Vec::is_empty);
    let placed = over.iter().take(3).any(|c| expected.contains(&c.as_str()));
    out.placed = (!over.is_empty()).then_some(placed);
    out.has_a_place = !expected.is_empty() && !of_channel;
    if label.kind == "single" && first {
        out.located = (!of_channel).then_some(placed);
        let stated = &leading["parameters"];
        let mut errors = Vec::new();
        for (name, truth) in &label.concealed[0].parameters {
            if let Some((value, std)) = quantity(&stated[name]) {
                errors.push(((value - truth) / truth).abs());
                out.parameters.0 += usize::from(std.is_finite());
                out.parameters.1 += usize::from((value - truth).abs() <= 1.96 * std);
            }
        }
        out.parameter_error = (!errors.is_empty()).then(|| errors.iter().sum::<f64>() / errors.len() as f64);
        // of the effects whose equation is that of the plant, nothing is left that could bend the baseline
        if !errors.is_empty() && named.len() == 1 {
            for (name, truth) in &label.baseline {
                if let Some((value, std)) = quantity(&answer["after"]["parameters"][name]) {
                    out.baseline.0 += 1;
                    out.baseline.1 += usize::from((value - truth).abs() <= 1.96 * std);
                }
            }
        }
        if named.len() == 1 {
            out.gain_covered = gain_covered(leading, &answer);
        }
    }
    if matches!(label.kind.as_str(), "single" | "pair") {
        out.explained = explained(places, case, &answer)?;
    }
    out.kind = label.kind;
    out.named = named;
    out.equal = equal;
    Ok(out)
}

/// What was named, physics and repaired channels alike, by what it gains.
fn entries(answer: &Value) -> Vec<&Value> {
    let gain = |m: &Value| {
        m["rms_heldout_before"].as_f64().unwrap_or(0.0) - m["rms_heldout_after"].as_f64().unwrap_or(0.0)
    };
    let mut out: Vec<&Value> = ["missing", "instruments"]
        .iter()
        .flat_map(|list| answer[*list].as_array().map(Vec::as_slice).unwrap_or_default())
        .collect();
    out.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
    out
}

fn json(path: &Path) -> Result<Value> {
    let bytes = std::fs::read(path).map_err(|e| Error::damaged(path, signals::files::reason(&e)))?;
    serde_json::from_slice(&bytes).map_err(|e| Error::damaged(path, e))
}

fn quantity(of: &Value) -> Option<(f64, f64)> {
    Some((of["value"].as_f64()?, of["std"].as_f64().unwrap_or(f64::NAN)))
}

/// The gain on a second record scatters as the first one's does: their difference by √2 more.
fn gain_covered(entry: &Value, answer: &Value) -> Option<bool> {
    let (low, high) = (entry["gain_ci95"][0].as_f64()?, entry["gain_ci95"][1].as_f64()?);
    let gain = entry["rms_heldout_before"].as_f64()? - entry["rms_heldout_after"].as_f64()?;
    let judge = &answer["validation"][0];
    let again = judge["rms_before"].as_f64()? - judge["rms_after"].as_f64()?;
    let wide = std::f64::consts::SQRT_2;
    Some(again >= gain - wide * (gain - low) && again <= gain + wide * (high - gain))
}

/// Cut-off behind which the truth's own velocity and acceleration are taken, Hz: there is no noise to keep out.
const SHARP: f64 = 250.0;

fn explained(places: &Places, case: usize, answer: &Value) -> Result<Option<f64>> {
    let truth = Recording::read(places.truth(case), &ReadOptions::default())?;
    let path = places.answer(case, "toml");
    if !path.exists() {
        return Ok(None);
    }
    let found = Model::read(&path)?;
    let baseline = baseline(answer, found.geometry);
    let judged = judged(&truth);
    let error = |model: Model| -> Result<f64> {
        let model = Model { cutoff_hz: Some(SHARP), ..model };
        let said = model.predict(&truth).map_err(|e| Error::damaged(&path, e))?;
        let rows = said.iter().zip(&truth.force).zip(&judged).filter(|(_, ok)| **ok);
        Ok(rows.map(|((p, f), _)| (p - f) * (p - f)).filter(|e| e.is_finite()).sum())
    };
    let (before, after) = (error(baseline)?, error(found)?);
    Ok((before > 0.0).then(|| 1.0 - after / before))
}

/// The frozen baseline of an answer, with zero for what fitted best below it: a large effect that was left out can push a mass
/// or a friction there, and no body has one.
fn baseline(answer: &Value, geometry: Geometry) -> Model {
    let value = |name: &str| quantity(&answer["baseline"]["parameters"][name]).map_or(0.0, |q| q.0);
    let physical = |name: &str| value(name).max(0.0);
    let (c_p, c_n) = (physical("coulomb_p"), physical("coulomb_n"));
    let law = Karnopp {
        c_p,
        c_n,
        b_p: physical("viscous_p"),
        b_n: physical("viscous_n"),
        d_p: c_p,
        d_n: c_n,
        delta_v: 0.0,
    };
    let mut baseline = Model { geometry, mass: physical("mass"), law: Law::Karnopp(law), ..Model::default() };
    baseline.nuisances.delay_s = value("delay");
    baseline
}

/// Share of the highest speed below which a body comes to rest: it creeps there for as long as the plant's friction is smooth,
/// and no recording tells that from standing.
const RESTS: f64 = 1e-3;

/// Samples of the truth that can be judged: sliding, and not within a few samples of a reversal or a rest, where the
/// moment of the edge would count for more than what is hidden.
fn judged(truth: &Recording) -> Vec<bool> {
    let at = truth.reference.as_deref().unwrap_or(&truth.position);
    let n = at.len();
    let moved = |i: usize| if i + 1 < n { at[i + 1] - at[i] } else { 0.0 };
    let rests = RESTS * (0..n).map(|i| moved(i).abs()).fold(0.0, f64::max);
    let slides = |j: usize, i: usize| moved(j) * moved(i) > 0.0 && moved(j).abs() > rests;
    (0..n).map(|i| (i.saturating_sub(5)..(i + 6).min(n)).all(|j| slides(j, i))).collect()
}

/// Wilson's 95 % interval of a share [wilson-1927].
pub(crate) fn wilson(hits: usize, of: usize) -> (f64, f64) {
    if of == 0 {
        return (0.0, 1.0);
    }
    let (n, z) = (of as f64, 1.96_f64);
    let p = hits as f64 / n;
    let centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    ((centre - half).max(0.0), (centre + half).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilson_agrees_with_the_textbook() {
        // [brown-2001]
        let (low, high) = wilson(0, 20);
        assert!(low.abs() < 1e-12 && (high - 0.1611).abs() < 1e-3, "{low} {high}");
        let (low, high) = wilson(95, 100);
        assert!((low - 0.8882).abs() < 1e-3 && (high - 0.9785).abs() < 1e-3, "{low} {high}");
    }

    /// Case 67 of seed 64, a spring and bristles at five times the noise, ended the scoring.
    #[test]
    fn a_baseline_that_fits_best_with_a_mass_below_zero_is_judged_with_none() {
        let answer = serde_json::json!({"baseline": {"parameters": {
            "mass": {"value": -0.0574, "std": 0.037}, "coulomb_p": {"value": 1.9}, "viscous_n": {"value": -2.0},
        }}});
        let model = baseline(&answer, Geometry::Linear);
        model.validate().unwrap();
        let Law::Karnopp(law) = model.law else { panic!("{:?}", model.law) };
        assert_eq!((model.mass, law.c_p, law.b_n), (0.0, 1.9, 0.0));
    }

    #[test]
    fn rests_and_reversals_are_not_judged() {
        let position: Vec<f64> = (0..100).map(|i| if i < 50 { f64::from(i) } else { 50.0 }).collect();
        let truth = Recording { reference: Some(position), ..Recording::default() };
        let ok = judged(&truth);
        assert!(ok[20] && !ok[49] && !ok[60]);
    }

    /// Case 25 of the open world, seed 7: 6 % of the samples moved by 4e-12 rad, and made an error of 0.03 N·m one of 0.37.
    #[test]
    fn a_body_that_moves_by_rounding_rests() {
        let creep = |i: usize| if i < 50 { i as f64 } else { 50.0 + 1e-12 * (i - 50) as f64 };
        let truth = Recording { reference: Some((0..100).map(creep).collect()), ..Recording::default() };
        assert!(!judged(&truth)[60]);
    }
}
