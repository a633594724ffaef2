//! Free forms in `model.toml`: physics without a name.
//!
//! ```toml
//! [[curve]]
//! over = "position"                # coordinate of `knots`
//! across = "velocity"              # second coordinate of a map, of `knots_across`; left out for a curve
//! times = "direction"              # what multiplies it: one, direction, velocity
//! memory_s = 0.5                   # s, of the coordinates `slid` and `moved`
//! knots = [-0.01, 0.0, 0.01]       # increasing
//! values = [0.0, 0.2, 0.0]         # N at the knots; of a map for each of `knots` at all of `knots_across`
//! ```

use crate::model_words::decimal;
use friction::{Coordinate, Factor, FreeForm, Invalid, Knots};
use std::fmt::Write;
use toml::de::{DeTable, DeValue};

/// The text of the free forms of a model.
pub(crate) fn write(curves: &[FreeForm<f64>]) -> String {
    let mut text = String::new();
    let list = |values: &[f64]| values.iter().map(|x| decimal(*x)).collect::<Vec<_>>().join(", ");
    for curve in curves {
        let _ = writeln!(text, "\n[[curve]] # physics without a name\nover = \"{}\"", curve.over.id());
        if let Some((across, _)) = &curve.across {
            let _ = writeln!(text, "across = \"{}\"", across.id());
        }
        let _ = writeln!(text, "times = \"{}\"", curve.times.id());
        let _ = writeln!(text, "memory_s = {}", decimal(curve.memory));
        let _ = writeln!(text, "knots = [{}]", list(curve.knots.places()));
        if let Some((_, knots)) = &curve.across {
            let _ = writeln!(text, "knots_across = [{}]", list(knots.places()));
        }
        let _ = writeln!(text, "values = [{}]", list(curve.values()));
    }
    text
}

/// Where in the text something is wrong, and what.
pub(crate) type Wrong = (usize, String);

const KEYS: [&str; 7] = ["over", "across", "times", "memory_s", "knots", "knots_across", "values"];

/// Reads the value of `curve`, which stands at `at`.
pub(crate) fn read(at: usize, value: &DeValue<'_>) -> Result<Vec<FreeForm<f64>>, Wrong> {
    let DeValue::Array(all) = value else {
        return Err((at, "curve: accepted is one [[curve]] for each free form".into()));
    };
    let of = |entry: &toml::Spanned<DeValue<'_>>| match entry.get_ref() {
        DeValue::Table(table) => one(entry.span().start, table),
        other => {
            Err((entry.span().start, format!("curve: accepted is a table, found: {}", other.type_str())))
        }
    };
    all.iter().map(of).collect()
}

fn one(at: usize, table: &DeTable<'_>) -> Result<FreeForm<f64>, Wrong> {
    for key in table.keys() {
        if !KEYS.contains(&key.get_ref().as_ref()) {
            let why = format!("curve.{}: accepted are {}", key.get_ref(), KEYS.join(", "));
            return Err((key.span().start, why));
        }
    }
    let numbers = |key: &str| -> Result<(usize, Vec<f64>), Wrong> {
        let Some(value) = table.get(key) else { return Err((at, format!("[[curve]] has no {key}"))) };
        let from = value.span().start;
        let list = match value.get_ref() {
            DeValue::Array(list) => list.iter().map(|x| number(x.get_ref())).collect::<Option<Vec<f64>>>(),
            _ => None,
        };
        list.map(|l| (from, l)).ok_or((from, format!("curve.{key}: accepted is a list of finite numbers")))
    };
    let word = |key: &str| -> Result<Option<(usize, String)>, Wrong> {
        let Some(value) = table.get(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::String(word) => Ok(Some((value.span().start, word.to_string()))),
            _ => Err((value.span().start, format!("curve.{key}: accepted is a word in quotes"))),
        }
    };
    let coordinate = |key: &str| -> Result<Option<Coordinate>, Wrong> {
        let Some((at, word)) = word(key)? else { return Ok(None) };
        let accepted = Coordinate::ALL.map(Coordinate::id).join(", ");
        let found = Coordinate::from_id(&word);
        found.map(Some).ok_or((at, format!("curve.{key} = \"{word}\": accepted: {accepted}")))
    };
    let wrong = |at: usize, of: &str| {
        let of = of.to_string();
        move |refused: Invalid| (at, format!("curve.{of}: {refused}"))
    };
    let over = coordinate("over")?.ok_or((at, "[[curve]] has no over".to_string()))?;
    let times = match word("times")? {
        None => Factor::One,
        Some((at, word)) => Factor::from_id(&word).ok_or_else(|| {
            (at, format!("curve.times = \"{word}\": accepted: {}", Factor::ALL.map(Factor::id).join(", ")))
        })?,
    };
    let (knots_at, places) = numbers("knots")?;
    let knots = Knots::new(&places).map_err(wrong(knots_at, "knots"))?;
    let (values_at, values) = numbers("values")?;
    let zero = vec![0.0; places.len()];
    let mut curve = FreeForm::curve(over, times, knots, &zero).map_err(wrong(knots_at, "knots"))?;
    if let Some(value) = table.get("memory_s") {
        let memory = number(value.get_ref()).unwrap_or(f64::NAN);
        curve.memory = memory;
        curve.validate().map_err(wrong(value.span().start, "memory_s"))?;
    }
    match coordinate("across")? {
        None => curve.with_values(&values),
        Some(across) => {
            let (at, places) = numbers("knots_across")?;
            let knots = Knots::new(&places).map_err(wrong(at, "knots_across"))?;
            curve.map(across, knots, &values)
        }
    }
    .map_err(wrong(values_at, "values"))
}

/// A finite number, whole or not.
fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(x) => x.as_str().parse().ok().filter(|x: &f64| x.is_finite()),
        DeValue::Integer(x) => i64::from_str_radix(x.as_str(), x.radix()).ok().map(|i| i as f64),
        _ => None,
    }
}
