//! Recordings from JSON: a list of samples, `[{"t": 0.0, "q": 0.1}, …]`, or an object of columns, `{"t": [0.0, …]}`.
//!
//! The samples are the file itself or a member of it with any name; the longest list is used. Numbers beside the list are constants
//! for a map, and texts and numbers beside it are metadata. `true` is 1, `false` is 0, `null` is a missing value.

use super::variables::{Variable, Wanted, assemble};
use crate::{Error, Recording};
use serde_json::Value;
use std::collections::BTreeMap;

pub(crate) fn read(file: &str, bytes: &[u8], wanted: &Wanted) -> Result<Recording, Error> {
    let fail = |why: String| Error::File { file: file.into(), why };
    let root: Value = serde_json::from_slice(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
        .map_err(|e| fail(format!("is not JSON: {e}")))?;
    let variables = variables(&root);
    if !variables.iter().any(|v| v.values.as_ref().is_some_and(|v| v.len() > 1)) {
        let accepted =
            r#"accepted is a list of samples, [{"time_s": 0.0, …}, …], or columns, {"time_s": [0.0, …], …}"#;
        return Err(fail(format!("has no samples; {accepted}")));
    }
    let mut recording = assemble(file, variables, wanted)?;
    recording.metadata.extend(metadata(&root));
    Ok(recording)
}

/// The number of a value: `true` is 1, `false` is 0.
pub(crate) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(n) => n.as_f64(),
        Value::Bool(b) => Some(f64::from(u8::from(*b))),
        _ => None,
    }
}

/// A number, or a missing one.
fn sample(value: &Value) -> Option<f64> {
    if value.is_null() { Some(f64::NAN) } else { number(value) }
}

/// A list whose members are objects: samples.
fn samples(value: &Value) -> Option<&Vec<Value>> {
    value.as_array().filter(|list| !list.is_empty() && list.iter().all(Value::is_object))
}

fn variables(root: &Value) -> Vec<Variable> {
    let mut out = Vec::new();
    let mut columns: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    let inside = root.as_object().into_iter().flat_map(|o| o.values());
    if let Some(list) = std::iter::once(root).chain(inside).filter_map(samples).max_by_key(|l| l.len()) {
        let names = list.iter().filter_map(Value::as_object).flat_map(|sample| sample.keys());
        for name in names {
            if !columns.contains_key(name.as_str()) {
                // what a sample lacks is not there; what is text is no number
                let of = |row: &Value| row.get(name).and_then(number).unwrap_or(f64::NAN);
                columns.insert(name, list.iter().map(of).collect());
            }
        }
    }
    for (name, value) in root.as_object().into_iter().flatten() {
        let column: Option<Vec<f64>> = match value {
            Value::Array(list) => list.iter().map(sample).collect(),
            single => sample(single).map(|v| vec![v]),
        };
        if let Some(column) = column
            && !columns.contains_key(name.as_str())
        {
            columns.insert(name, column);
        }
    }
    for (name, values) in columns {
        let kind = if values.len() == 1 { "number" } else { "list" };
        out.push(Variable::column(name, kind, values));
    }
    out
}

/// Text and numbers beside the samples.
fn metadata(root: &Value) -> BTreeMap<String, String> {
    let mut out = BTreeMap::new();
    for (name, value) in root.as_object().into_iter().flatten() {
        match value {
            Value::String(text) => out.insert(name.clone(), text.clone()),
            Value::Number(number) => out.insert(name.clone(), number.to_string()),
            _ => None,
        };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Map;

    fn read(file: &str, bytes: &[u8], map: Option<&Map>) -> Result<Recording, Error> {
        super::read(file, bytes, &Wanted { map: &|_| map, joint: None })
    }

    #[test]
    fn samples_columns_constants_and_holes_are_read() {
        let map: Map = "time_s=t,position_rad=q,torque_nm=max(-12, min(12, kp*(goal-q)*on))".parse().unwrap();
        let text = br#"{"kp": 10, "motor": "x", "log": [{"t": 0, "q": 0.0, "goal": 0.1, "on": true},
            {"t": 0.1, "q": null, "goal": 5, "on": true}, {"t": 0.2, "q": 1.0, "goal": 9, "on": true},
            {"t": 0.3, "q": 1.0, "goal": 9, "on": false}]}"#;
        let r = read("a.json", text, Some(&map)).unwrap();
        assert_eq!(r.force[0], 1.0);
        assert!(r.position[1].is_nan() && r.force[1].is_nan());
        assert_eq!(r.force[2..], [12.0, 0.0]);
        assert_eq!(r.metadata["motor"], "x");
        let columns = br#"{"time_s": [0, 1], "position_m": [1, 2], "force_n": [3, 4]}"#;
        assert_eq!(read("b.json", columns, None).unwrap().force, [3.0, 4.0]);
        for (bad, says) in [
            (&b"[1, 2"[..], "is not JSON"),
            (b"{}", "has no samples"),
            (b"[]", "has no samples"),
            (br#"[{"a": 1}, {"a": 2}]"#, "a (2 list)"),
        ] {
            let said = read("bad.json", bad, None).unwrap_err().to_string();
            assert!(said.contains("bad.json") && said.contains(says), "{said}");
        }
    }
}
