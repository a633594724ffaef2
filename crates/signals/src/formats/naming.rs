//! What the headings of a table say: which column is which, in which unit, and of which joint.
//!
//! A heading is a name of a recording (`position_m`), a quantity with a unit of its own (`position` in `mm`), or either with a
//! joint's label before, behind or within it: `j2_position_rad`, `position_rad[2]`, `position_j2_rad`.

use super::columns::{self, Named, Slot};
use super::units::{self, Unit, Unread};

/// The name of a column and, where the file says it apart from the name, its unit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heading<'a> {
    pub name: &'a str,
    pub unit: Option<&'a str>,
}

/// What a column is for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Role {
    /// A column of the recording, and the unit it has in the file.
    Column(&'static Named, Unit),
    /// One more column of numbers.
    Extra,
}

/// The roles of all columns, and what a user should know of them.
#[derive(Debug)]
pub(crate) struct Roles {
    pub roles: Vec<Role>,
    pub remarks: Vec<String>,
}

/// Why headings make no recording: the heading, if it is one, and what would be accepted.
#[derive(Debug)]
pub(crate) struct Refusal {
    pub heading: Option<usize>,
    pub why: String,
}

/// A heading that names a column.
struct Match<'a> {
    column: &'static Named,
    unit: Unit,
    /// The joint's label.
    label: Option<&'a str>,
}

/// Gives each heading its role; `joint` is the label of the joint that is asked for.
///
/// # Errors
/// The heading that is unknown, twice there, in a unit that does not fit, or the joints there are.
pub(crate) fn roles(headings: &[Heading], joint: Option<&str>) -> Result<Roles, Refusal> {
    let refuse = |heading: usize, why: String| Refusal { heading: Some(heading), why };
    let mut matches = Vec::with_capacity(headings.len());
    for (i, heading) in headings.iter().enumerate() {
        matches.push(matched(*heading).map_err(|why| refuse(i, why))?);
    }
    if let Some(joint) = joint
        && !matches.iter().flatten().any(|m| m.label.is_some_and(|l| same_label(l, joint)))
    {
        let joints = joints(&matches);
        let why = if joints.is_empty() {
            format!("no joint `{joint}`: no column has a joint's label")
        } else {
            format!("no joint `{joint}`; {}", listed(&joints))
        };
        return Err(Refusal { heading: None, why });
    }
    let of_joint = |m: &Match| match (m.label, joint) {
        (None, _) => true,
        (Some(label), Some(joint)) => same_label(label, joint),
        (Some(_), None) => false,
    };
    let mut roles = vec![Role::Extra; headings.len()];
    let mut given: Vec<&'static Named> = Vec::new();
    for (i, m) in matches.iter().enumerate() {
        let Some(m) = m.as_ref().filter(|m| of_joint(m)) else { continue };
        if let Some(other) = given.iter().find(|o| columns::contradict(o, m.column)) {
            return Err(refuse(
                i,
                format!("beside {}; accepted is a slide or an axis, not both", other.name),
            ));
        }
        if let Some(other) = given.iter().find(|o| o.slot == m.column.slot) {
            return Err(refuse(i, format!("is there twice (as {}); accepted is one", other.name)));
        }
        given.push(m.column);
        roles[i] = Role::Column(m.column, m.unit);
    }
    if joint.is_none() && !columns::sufficient(given.iter().map(|c| c.slot)) {
        let joints = joints(&matches);
        if !joints.is_empty() {
            return Err(Refusal { heading: None, why: format!("several joints; {}", listed(&joints)) });
        }
    }
    for (i, heading) in headings.iter().enumerate() {
        if matches[i].is_some() {
            continue;
        }
        // what is there under a name that is understood was not meant by one that is not
        let meant = columns::meant(heading.name);
        let missing =
            |name: &&str| columns::find(name).is_some_and(|c| given.iter().all(|g| g.slot != c.slot));
        if meant.iter().any(missing) {
            let advice = columns::advice(heading.name);
            return Err(refuse(i, format!("is an unknown column; {advice}")));
        }
    }
    let mut converted = Vec::new();
    for (heading, role) in headings.iter().zip(&roles) {
        if let Role::Column(column, unit) = role
            && !unit.is_si()
        {
            let from =
                heading.unit.or_else(|| bracketed(heading.name).map(|(_, unit)| unit)).unwrap_or_default();
            converted.push(format!("{} from {} to {}", heading.name, inside(from), columns::si(column)));
        }
    }
    let remarks =
        if converted.is_empty() { Vec::new() } else { vec![format!("converted: {}", converted.join(", "))] };
    Ok(Roles { roles, remarks })
}

/// The labels of the joints that have a position and a force, in the file's order.
fn joints<'a>(matches: &[Option<Match<'a>>]) -> Vec<&'a str> {
    let mut out: Vec<&str> = Vec::new();
    let has = |label: &str, slot: Slot| {
        matches
            .iter()
            .flatten()
            .any(|m| m.column.slot == slot && m.label.is_none_or(|l| same_label(l, label)))
    };
    for label in matches.iter().flatten().filter_map(|m| m.label) {
        if has(label, Slot::Position) && has(label, Slot::Force) && !out.iter().any(|o| same_label(o, label))
        {
            out.push(label);
        }
    }
    out
}

/// "accepted is --joint with one of a, b".
fn listed(joints: &[&str]) -> String {
    format!("accepted is --joint with one of {}", joints.join(", "))
}

/// The column that a heading names, if any.
fn matched(heading: Heading<'_>) -> Result<Option<Match<'_>>, String> {
    let (name, unit) = match (heading.unit, bracketed(heading.name)) {
        (Some(unit), _) => (heading.name, Some(unit)),
        (None, Some((name, unit))) => (name, Some(unit)),
        (None, None) => (heading.name, None),
    };
    let full = best(name, columns::ALL.iter().map(|n| (n.name, n)));
    // `Position_M` is not how a recording names it
    if let Some((column, label)) = full.filter(|(column, label)| label.is_some() || column.name == name) {
        let unit = match unit {
            None => si(column)?,
            Some(text) => match units::parse(text) {
                Ok(unit) if unit.is_si() && columns::in_unit(column.slot, unit) == Some(column) => unit,
                _ => {
                    return Err(format!(
                        "is in {} by its name and in {} by its unit; accepted is one of them",
                        columns::si(column),
                        inside(text)
                    ));
                }
            },
        };
        return Ok(Some(Match { column, unit, label }));
    }
    let Some((slot, label)) = best(name, columns::QUANTITIES.iter().map(|(word, slot)| (*word, *slot)))
    else {
        return Ok(None);
    };
    let Some(text) = unit else { return Ok(None) };
    let fitting = units::parse(text).map_err(|why| match why {
        Unread::Counts => format!(
            "is in {}, whose worth is not in the file; accepted is a map, such as \
             time_s='t',position_m='x'*1e-6,force_n='F'",
            inside(text)
        ),
        Unread::Unknown => {
            format!("is in `{}`, an unknown unit; accepted are {}", inside(text), units::ACCEPTED)
        }
    })?;
    match columns::in_unit(slot, fitting) {
        Some(column) => Ok(Some(Match { column, unit: fitting, label })),
        None => Err(format!("is in {}, which does not measure it", inside(text))),
    }
}

/// The unit that a full name says.
fn si(column: &Named) -> Result<Unit, String> {
    units::parse(&columns::si(column)).map_err(|_| format!("{} has no unit", column.name))
}

/// The word that leaves the fewest parts of a name, with those parts: a joint's label.
fn best<T>(name: &str, words: impl Iterator<Item = (&'static str, T)>) -> Option<(T, Option<&str>)> {
    let parts = parts(name);
    let mut best: Option<(usize, T, Option<&str>)> = None;
    for (word, value) in words {
        let wanted: Vec<&str> = word.split('_').collect();
        let Some(label) = labels(&parts, &wanted).next() else { continue };
        if best.as_ref().is_some_and(|(fewest, ..)| *fewest <= label.len()) {
            continue;
        }
        let text = label.first().zip(label.last()).map(|(first, last)| &name[first.0..last.0 + last.1.len()]);
        best = Some((label.len(), value, text));
    }
    best.map(|(_, value, label)| (value, label))
}

/// The labels that the parts of a name can have beside a word: one run of parts, with the word before and behind it. The last
/// place comes first.
fn labels<'p, 'a>(parts: &'p [Part<'a>], word: &[&str]) -> impl Iterator<Item = &'p [Part<'a>]> {
    let equal = |parts: &[Part], word: &[&str]| {
        parts.iter().zip(word).all(|((_, part), word)| part.eq_ignore_ascii_case(word))
    };
    let left = parts.len().checked_sub(word.len());
    let places = left.into_iter().flat_map(|left| (0..=word.len()).rev().map(move |k| (k, k + left)));
    places
        .filter(move |&(k, end)| equal(&parts[..k], &word[..k]) && equal(&parts[end..], &word[k..]))
        .map(|(k, end)| &parts[k..end])
}

/// A run of letters and digits, with its place in the name.
type Part<'a> = (usize, &'a str);

fn parts(name: &str) -> Vec<Part<'_>> {
    let mut out = Vec::new();
    let mut start = None;
    for (at, c) in name.char_indices().chain(std::iter::once((name.len(), ' '))) {
        match (c.is_alphanumeric(), start) {
            (true, None) => start = Some(at),
            (false, Some(from)) => {
                out.push((from, &name[from..at]));
                start = None;
            }
            _ => {}
        }
    }
    out
}

fn same_label(one: &str, other: &str) -> bool {
    same_parts(&parts(one), &parts(other))
}

fn same_parts(one: &[Part], other: &[Part]) -> bool {
    one.len() == other.len() && one.iter().zip(other).all(|(a, b)| a.1.eq_ignore_ascii_case(b.1))
}

/// `Position [mm]` → `Position`, `mm`. A number in brackets is an index.
fn bracketed(name: &str) -> Option<(&str, &str)> {
    let (open, _) = name.char_indices().find(|(_, c)| matches!(c, '[' | '('))?;
    let (quantity, unit) = name.split_at(open);
    let text = unit.strip_suffix(if unit.starts_with('[') { ']' } else { ')' })?;
    let known = units::parse(unit) != Err(Unread::Unknown);
    (known && text.parse::<f64>().is_err()).then_some((quantity.trim_end(), unit))
}

/// A unit without its brackets.
fn inside(unit: &str) -> &str {
    unit.trim().trim_matches(['[', ']', '(', ')'])
}

/// The joint of a label in a name, for a map's variable: whether `name` is `variable` with that label.
pub(crate) fn is_of_joint(name: &str, variable: &str, joint: &str) -> bool {
    let (name, joint) = (parts(name), parts(joint));
    let variable: Vec<&str> = parts(variable).into_iter().map(|(_, part)| part).collect();
    labels(&name, &variable).any(|label| same_parts(label, &joint))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(names: &[&str], joint: Option<&str>) -> Result<Vec<Option<&'static str>>, String> {
        let headings: Vec<Heading> = names.iter().map(|name| Heading { name, unit: None }).collect();
        let roles = roles(&headings, joint).map_err(|r| r.why)?;
        let name = |role: &Role| match role {
            Role::Column(column, _) => Some(column.name),
            Role::Extra => None,
        };
        Ok(roles.roles.iter().map(name).collect())
    }

    #[test]
    fn labels_stand_before_behind_and_within() {
        for names in [
            ["time_s", "j1_position_rad", "j1_torque_nm", "j2_position_rad", "j2_torque_nm"],
            ["time_s", "position_rad_j1", "torque_nm_j1", "position_rad_j2", "torque_nm_j2"],
            ["time_s", "position_j1_rad", "torque_j1_nm", "position_j2_rad", "torque_j2_nm"],
            ["time_s", "j1/position_rad", "j1/torque_nm", "J2/position_rad", "J2/torque_nm"],
            ["time_s", "j1.position [deg]", "j1.torque [Nm]", "j2.position [deg]", "j2.torque [Nm]"],
        ] {
            let second = [Some("time_s"), None, None, Some("position_rad"), Some("torque_nm")];
            assert_eq!(read(&names, Some("j2")).unwrap(), second, "{names:?}");
            let said = read(&names, None).unwrap_err();
            assert!(
                said.contains("several joints") && said.contains("--joint") && said.contains("j1, "),
                "{said}"
            );
            assert!(
                read(&names, Some("j3"))
                    .unwrap_err()
                    .contains("no joint `j3`; accepted is --joint with one of j1")
            );
        }
        let indexed = ["time_s", "position_rad[1]", "torque_nm[1]", "position_rad[2]", "torque_nm[2]"];
        assert_eq!(read(&indexed, Some("2")).unwrap()[3], Some("position_rad"));
    }

    #[test]
    fn plain_columns_need_no_joint() {
        let names = ["time_s", "position_rad", "torque_nm", "position_rad_2", "torque_nm_2", "supply_v"];
        let plain = [Some("time_s"), Some("position_rad"), Some("torque_nm"), None, None, None];
        assert_eq!(read(&names, None).unwrap(), plain);
        assert!(read(&names, Some("2")).unwrap_err().contains("is there twice"));
        assert!(read(&names[..3], Some("2")).unwrap_err().contains("no joint `2`"));
    }

    #[test]
    fn a_unit_that_does_not_fit_is_refused() {
        let read = |name, unit| roles(&[Heading { name, unit: Some(unit) }], None);
        for (name, unit, says) in [
            ("position", "counts", "map"),
            ("position", "furlong", "unknown unit; accepted are s, ms"),
            ("position", "N", "does not measure it"),
            ("position_m", "mm", "in m by its name and in mm by its unit"),
        ] {
            let why = read(name, unit).unwrap_err().why;
            assert!(why.contains(says), "{why}");
        }
        let roles = read("position", "[mm]").unwrap();
        assert_eq!(roles.remarks, ["converted: position from mm to m"]);
    }
}
