//! A line of an answer.

use core::fmt::{self, Write};
use friction::Geometry;
use heapless::String;

/// Longest line of an answer, bytes.
pub(super) const LINE: usize = 480;
/// A line being written. Truncated at its capacity.
pub(super) type Line = String<LINE>;

/// Scale and unit of a printed travel of the handle: a slide moves by millimetres.
pub(super) const fn travel(geometry: Geometry) -> (f32, &'static str) {
    match geometry {
        Geometry::Linear => (1e3, "mm"),
        Geometry::Rotary => (1.0, "rad"),
    }
}

/// `err CODE: why`
pub(super) fn err(code: &str, why: impl fmt::Display, out: &mut Line) {
    // a long line is truncated; nothing else can fail
    let _ = out.write_str("err ");
    for c in code.chars() {
        let _ = out.push(c.to_ascii_uppercase());
    }
    let _ = write!(out, ": {why}");
}
