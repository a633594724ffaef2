//! Named arrays, which most kinds of file hold, and the recording they make: by a map, or by their own names.

use super::columns::{self, Named};
use super::naming::{self, Heading, Role};
use super::units;
use crate::error::Place;
use crate::{Error, Map, Recording};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Metadata key of the columns of a file that are none of a recording's.
pub(crate) const NOT_USED: &str = "columns_not_used";

/// Metadata key of the time that `time_s` counts from, ns since 1970.
#[cfg(any(feature = "parquet", feature = "ros2"))]
pub(crate) const TIME_ZERO: &str = "time_zero_ns";

/// A variable of a file.
#[derive(Debug, Clone, Default)]
pub(crate) struct Variable {
    pub name: String,
    /// `double`, `struct`, …
    pub kind: &'static str,
    /// As the file's software says it.
    pub size: Vec<usize>,
    /// The last index of `size` runs fastest, as in C; otherwise the first, as in MATLAB.
    pub last_fastest: bool,
    /// Elements in the file's order, if it is a real numeric array.
    pub values: Option<Vec<f64>>,
    /// Where the file says it apart from the name.
    pub unit: Option<String>,
}

impl Variable {
    /// A column of numbers.
    pub(crate) fn column(name: impl Into<String>, kind: &'static str, values: Vec<f64>) -> Self {
        Self { name: name.into(), kind, size: vec![values.len()], values: Some(values), ..Self::default() }
    }

    /// What is there, and no numbers.
    pub(crate) fn other(name: impl Into<String>, kind: &'static str, size: Vec<usize>) -> Self {
        Self { name: name.into(), kind, size, ..Self::default() }
    }

    fn says(&self) -> String {
        let size = self.size.iter().map(usize::to_string).collect::<Vec<_>>().join("x");
        let unit = self.unit.as_ref().map(|u| format!(", {u}")).unwrap_or_default();
        format!("{} ({size} {}{unit})", self.name, self.kind)
    }

    /// Columns of a matrix of samples by joints, `q[1]`, `q[2]`, …, counted from 1: the longer side is the time.
    fn split(self) -> Vec<Self> {
        let [rows, columns] = self.size[..] else { return vec![self] };
        let Some(values) = self.values.as_ref().filter(|_| rows > 1 && columns > 1 && rows != columns) else {
            return vec![self];
        };
        let (samples, joints) = (rows.max(columns), rows.min(columns));
        // whether a joint's samples lie one behind the other
        let joined = (rows > columns) != self.last_fastest;
        let column = |k: usize| Self {
            name: format!("{}[{}]", self.name, k + 1),
            size: vec![samples],
            values: Some(match joined {
                true => values[k * samples..(k + 1) * samples].to_vec(),
                false => values.iter().skip(k).step_by(joints).copied().collect(),
            }),
            ..Self { values: None, ..self.clone_head() }
        };
        (0..joints).map(column).collect()
    }

    fn clone_head(&self) -> Self {
        Self { name: String::new(), unit: self.unit.clone(), kind: self.kind, ..Self::default() }
    }
}

/// The map to read a file with, by whether it has a variable of a name.
pub(crate) type Choice<'a, 'm> = &'a dyn Fn(&dyn Fn(&str) -> bool) -> Option<&'m Map>;

/// What of a file is wanted.
pub(crate) struct Wanted<'a, 'm> {
    pub map: Choice<'a, 'm>,
    /// Label of the joint.
    pub joint: Option<&'a str>,
}

/// The recording that the variables of a file make, by a map or by their own names.
pub(crate) fn assemble(file: &str, variables: Vec<Variable>, wanted: &Wanted) -> Result<Recording, Error> {
    let has = variables.iter().map(Variable::says).collect::<Vec<_>>().join(", ");
    let indexed = variables.iter().filter(|v| v.size.len() == 2 && v.size.iter().all(|n| *n > 1)).count();
    let variables: Vec<Variable> = variables.into_iter().flat_map(Variable::split).collect();
    let numbers = |name: &str| variables.iter().find(|v| v.name == name)?.values.as_deref();
    let of_joint = |name: &str| {
        let labelled = |v: &&Variable| wanted.joint.is_some_and(|j| naming::is_of_joint(&v.name, name, j));
        numbers(name).or_else(|| variables.iter().find(labelled)?.values.as_deref())
    };
    let mut recording = match (wanted.map)(&|name| of_joint(name).is_some()) {
        Some(map) => {
            let made = map.apply(of_joint, &has)?;
            let mut made = columns::assemble(made).map_err(|missing| Error::Map {
                map: map.text().into(),
                column: 1,
                why: format!("no {missing}; a recording needs time, position and force; the file has {has}"),
            })?;
            let unit = |name: &str| variables.iter().find(|v| v.name == name)?.unit.as_deref();
            made.remarks.extend(units_of_map(map, unit));
            made
        }
        None => named(file, variables, &has, wanted.joint)?,
    };
    if let Some(joint) = wanted.joint.filter(|_| indexed > 0) {
        recording.remarks.push(format!("joint {joint}: columns of arrays are counted from 1"));
    }
    Ok(recording)
}

/// A map sees the numbers of the file: said where their unit is another than SI.
pub(crate) fn units_of_map<'u>(map: &Map, unit: impl Fn(&str) -> Option<&'u str>) -> Option<String> {
    let foreign: Vec<String> = map
        .variables()
        .iter()
        .filter_map(|name| Some((name, unit(name)?)))
        .filter(|(_, unit)| !units::parse(unit).is_ok_and(units::Unit::is_si))
        .map(|(name, unit)| format!("{name} in {unit}"))
        .collect();
    (!foreign.is_empty())
        .then(|| format!("the map computes with the numbers of the file: {}", foreign.join(", ")))
}

/// Without a map, variables may have the names of columns.
fn named(
    file: &str,
    mut variables: Vec<Variable>,
    has: &str,
    joint: Option<&str>,
) -> Result<Recording, Error> {
    let input = |value: &str, accepted: String| Error::Input {
        file: file.into(),
        place: Place::default(),
        value: value.into(),
        accepted,
    };
    let among = |value: &str, why: String| {
        let map = "say what they are with a map such as time_s=t,position_m=x,force_n=k*u";
        input(value, format!("{why}; the file has {has}; {map}"))
    };
    let fail = |why: String| among("", why);
    variables.retain(|v| v.values.is_some());
    let headings: Vec<Heading> =
        variables.iter().map(|v| Heading { name: &v.name, unit: v.unit.as_deref() }).collect();
    let naming::Roles { roles, remarks } = match naming::roles(&headings, joint) {
        Ok(roles) => roles,
        Err(refusal) => match refusal.heading {
            Some(i) => return Err(among(&variables[i].name, refusal.why)),
            None => return Err(input("", format!("{}; the file has {has}", refusal.why))),
        },
    };
    let mut found: Vec<(&'static Named, Vec<f64>)> = Vec::new();
    let mut extra: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (variable, role) in variables.into_iter().zip(roles) {
        let values = variable.values.unwrap_or_default();
        match role {
            Role::Column(column, unit) => found.push((column, unit.all_to_si(values))),
            Role::Extra => drop(extra.insert(variable.name, values)),
        }
    }
    let mut recording = columns::assemble(found).map_err(|missing| fail(format!("no variable {missing}")))?;
    match recording.check_lengths() {
        Err(Error::Recording { why, .. }) => return Err(fail(why)),
        _ if recording.is_empty() => return Err(fail("no samples".into())),
        _ => {}
    }
    let (samples, other): (BTreeMap<_, _>, BTreeMap<_, _>) =
        extra.into_iter().partition(|(_, values)| values.len() == recording.len());
    recording.extra = samples;
    recording.remarks = remarks;
    if !other.is_empty() {
        let names: Vec<String> = other.into_keys().collect();
        recording.metadata.insert(NOT_USED.into(), names.join(", "));
    }
    Ok(recording)
}

/// A text on one line.
pub(crate) fn one_line(text: &str) -> Cow<'_, str> {
    if text.contains(['\n', '\r']) { text.replace(['\n', '\r'], " ").into() } else { text.into() }
}

/// The recording of columns in memory, by a map or by their own names.
pub(crate) fn of_columns(
    name: &str,
    columns: Vec<(String, Vec<f64>)>,
    wanted: &Wanted,
) -> Result<Recording, Error> {
    let lengths: Vec<(String, usize)> = columns.iter().map(|(name, v)| (name.clone(), v.len())).collect();
    let variables =
        columns.into_iter().map(|(name, values)| Variable::column(name, "column", values)).collect();
    let recording = assemble(name, variables, wanted)?;
    let unused =
        |column: &&(String, usize)| recording.metadata.contains_key(NOT_USED) && column.1 != recording.len();
    match lengths.iter().find(unused) {
        Some((column, n)) => Err(Error::Recording {
            recording: name.into(),
            why: format!("{column} has {n} samples, time_s has {}", recording.len()),
        }),
        None => Ok(recording),
    }
}
