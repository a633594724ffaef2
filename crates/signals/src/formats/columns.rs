//! Names of columns, with their units, and the recording made of named columns.

use super::units::Unit;
use crate::{Geometry, Recording};
use friction::Dimension;

/// What a column is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Slot {
    Time,
    Position,
    Velocity,
    Acceleration,
    Force,
    NormalForce,
    Command,
    Reference,
    Temperature,
}

impl Slot {
    /// What its numbers measure; None for a temperature.
    pub(crate) const fn dimension(self) -> Option<Dimension> {
        Some(match self {
            Self::Time => Dimension::TIME,
            Self::Position | Self::Reference => Dimension::LENGTH,
            Self::Velocity => Dimension::VELOCITY,
            Self::Acceleration => Dimension::ACCELERATION,
            Self::Force | Self::Command => Dimension::FORCE,
            Self::NormalForce => Dimension::LOAD,
            Self::Temperature => return None,
        })
    }
}

/// A name a column can have in a file.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Named {
    pub name: &'static str,
    pub slot: Slot,
    /// None where slide and axis have it alike.
    pub geometry: Option<Geometry>,
}

const fn named(name: &'static str, slot: Slot, geometry: Option<Geometry>) -> Named {
    Named { name, slot, geometry }
}

const SLIDE: Option<Geometry> = Some(Geometry::Linear);
const AXIS: Option<Geometry> = Some(Geometry::Rotary);

/// Every name there is.
pub(crate) static ALL: [Named; 15] = [
    named("time_s", Slot::Time, None),
    named("position_m", Slot::Position, SLIDE),
    named("position_rad", Slot::Position, AXIS),
    named("velocity_m_s", Slot::Velocity, SLIDE),
    named("velocity_rad_s", Slot::Velocity, AXIS),
    named("acceleration_m_s2", Slot::Acceleration, SLIDE),
    named("acceleration_rad_s2", Slot::Acceleration, AXIS),
    named("force_n", Slot::Force, SLIDE),
    named("torque_nm", Slot::Force, AXIS),
    named("normal_force_n", Slot::NormalForce, None),
    named("command_n", Slot::Command, None),
    named("command_nm", Slot::Command, AXIS),
    // The two of a slide serve an axis as well: no other name is promised for them.
    named("reference_m", Slot::Reference, None),
    named("reference_rad", Slot::Reference, AXIS),
    named("temperature_c", Slot::Temperature, None),
];

/// Names of quantities without a unit; the longer before the shorter that it contains.
pub(crate) static QUANTITIES: [(&str, Slot); 10] = [
    ("normal_force", Slot::NormalForce),
    ("acceleration", Slot::Acceleration),
    ("temperature", Slot::Temperature),
    ("position", Slot::Position),
    ("velocity", Slot::Velocity),
    ("reference", Slot::Reference),
    ("command", Slot::Command),
    ("torque", Slot::Force),
    ("force", Slot::Force),
    ("time", Slot::Time),
];

/// A column's name without its unit: `position_m` → `position`.
pub(crate) fn quantity(name: &str) -> &str {
    QUANTITIES.iter().map(|(quantity, _)| *quantity).find(|q| name.starts_with(q)).unwrap_or(name)
}

/// The column that a quantity in a unit is, once in SI.
pub(crate) fn in_unit(slot: Slot, unit: Unit) -> Option<&'static Named> {
    let load =
        slot == Slot::NormalForce && unit.geometry == SLIDE && unit.dimension == Some(Dimension::FORCE);
    if !load && slot.dimension() != unit.dimension {
        return None;
    }
    let of = |geometry| ALL.iter().find(|n| n.slot == slot && n.geometry == geometry);
    of(unit.geometry).or_else(|| of(None).filter(|_| unit.geometry != AXIS))
}

/// SI unit of a column, as people write it.
pub(crate) fn si(column: &Named) -> String {
    let unit = |d: Dimension| d.unit(column.geometry.unwrap_or_default()).to_string();
    column.slot.dimension().map_or_else(|| "°C".into(), unit)
}

/// Whether these columns make a recording.
pub(crate) fn sufficient(slots: impl Iterator<Item = Slot>) -> bool {
    let slots: Vec<Slot> = slots.collect();
    [Slot::Time, Slot::Position, Slot::Force].iter().all(|needed| slots.contains(needed))
}

/// The column with this name.
pub(crate) fn find(name: &str) -> Option<&'static Named> {
    ALL.iter().find(|n| n.name == name)
}

/// One is of a slide, the other of an axis.
pub(crate) fn contradict(one: &Named, other: &Named) -> bool {
    matches!((one.geometry, other.geometry), (Some(a), Some(b)) if a != b)
}

/// Names that a wrong one may have been meant to be: the same quantity in another unit, or a slip of the pen.
pub(crate) fn meant(name: &str) -> Vec<&'static str> {
    let name = name.trim().to_lowercase();
    let same = |n: &&Named| {
        let quantity = quantity(n.name);
        name == quantity
            || name.strip_prefix(quantity).is_some_and(|unit| !unit.starts_with(char::is_alphanumeric))
    };
    let mut out: Vec<&str> = ALL.iter().filter(same).map(|n| n.name).collect();
    if out.is_empty() {
        out = ALL.iter().map(|n| n.name).filter(|n| distance(n, &name) <= 2).collect();
    }
    out
}

/// What would be accepted in place of a name.
pub(crate) fn advice(name: &str) -> String {
    let meant = meant(name);
    if meant.is_empty() {
        let all: Vec<&str> = ALL.iter().map(|n| n.name).collect();
        return format!("accepted are {}", all.join(", "));
    }
    format!("accepted is {}, in SI units as the name says", meant.join(" or "))
}

/// Letters to change, add or leave out to get from one word to the other.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row.last().copied().unwrap_or(0)
}

/// A recording of the columns, or the names of which one is missing.
pub(crate) fn assemble(columns: Vec<(&'static Named, Vec<f64>)>) -> Result<Recording, &'static str> {
    let rotary = columns.iter().any(|(n, _)| n.geometry == AXIS);
    let mut out = Recording {
        geometry: if rotary { Geometry::Rotary } else { Geometry::Linear },
        ..Recording::default()
    };
    let mut missing = vec!["time_s", "position_m or position_rad", "force_n or torque_nm"];
    for (column, values) in columns {
        match column.slot {
            Slot::Time => out.time = values,
            Slot::Position => out.position = values,
            Slot::Force => out.force = values,
            Slot::Velocity => out.velocity = Some(values),
            Slot::Acceleration => out.acceleration = Some(values),
            Slot::NormalForce => out.normal_force = Some(values),
            Slot::Command => out.command = Some(values),
            Slot::Reference => out.reference = Some(values),
            Slot::Temperature => out.temperature = Some(values),
        }
        missing.retain(|m| !m.split(" or ").any(|name| name == column.name));
    }
    match missing.first() {
        Some(first) => Err(first),
        None => Ok(out),
    }
}
