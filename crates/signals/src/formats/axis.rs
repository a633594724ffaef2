//! One axis of a recording in the plane, read as a recording on a line by a map.

use crate::Map;
use std::cell::{Cell, OnceCell};

/// Columns of a recording in the plane: what each is on a line, and its name for x and for y.
const PAIRS: [(&str, [&str; 2]); 4] = [
    ("position_m", ["position_x_m", "position_y_m"]),
    ("force_n", ["force_x_n", "force_y_n"]),
    ("velocity_m_s", ["velocity_x_m_s", "velocity_y_m_s"]),
    ("acceleration_m_s2", ["acceleration_x_m_s2", "acceleration_y_m_s2"]),
];

/// Columns of [`PAIRS`] that a recording needs.
const NEEDED: usize = 2;

/// Which columns of [`PAIRS`] a file has.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Found {
    pairs: [[bool; 2]; PAIRS.len()],
    line: bool,
}

impl Found {
    fn of(has: &dyn Fn(&str) -> bool) -> Self {
        let pairs = PAIRS.map(|(_, names)| names.map(has));
        Self { pairs, line: has("position_m") && has("force_n") }
    }

    fn is_planar(&self) -> bool {
        !self.line && self.pairs[..NEEDED].iter().flatten().any(|there| *there)
    }
}

/// Whether a file with these columns is a recording in the plane, or half of one.
pub(crate) fn is_planar(has: &dyn Fn(&str) -> bool) -> bool {
    Found::of(has).is_planar()
}

/// An axis to be read, and what reading saw of the columns.
#[derive(Debug, Default)]
pub(crate) struct Axis {
    index: usize,
    found: Cell<Found>,
    map: OnceCell<Option<Map>>,
}

impl Axis {
    pub(crate) fn new(index: usize) -> Self {
        Self { index, ..Self::default() }
    }

    /// The map that makes this axis a recording; None where the file is not one in the plane.
    pub(crate) fn map(&self, has: &dyn Fn(&str) -> bool) -> Option<&Map> {
        let found = Found::of(has);
        self.found.set(found);
        if !found.is_planar() || self.missing().is_some() {
            return None;
        }
        let text = || {
            let there = PAIRS.iter().zip(found.pairs).filter(|(_, pair)| pair[self.index]);
            let columns = there.map(|((line, names), _)| format!(",{line}={}", names[self.index]));
            format!("time_s=time_s{}", columns.collect::<String>())
        };
        self.map.get_or_init(|| text().parse().ok()).as_ref()
    }

    /// Whether the file is a recording in the plane, or half of one.
    pub(crate) fn is_planar(&self) -> bool {
        self.found.get().is_planar()
    }

    /// What is missing, in words.
    pub(crate) fn missing(&self) -> Option<String> {
        for (i, (_, [x, y])) in PAIRS.iter().enumerate() {
            let (there, lacks) = match self.found.get().pairs[i] {
                [true, false] => (x, y),
                [false, true] => (y, x),
                [false, false] if i < NEEDED => {
                    return Some(format!("no {x} and {y}: a recording in the plane needs both"));
                }
                _ => continue,
            };
            return Some(format!("{there} without {lacks}: a recording in the plane has both, or neither"));
        }
        None
    }
}
