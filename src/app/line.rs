//! A line of an answer.

use core::fmt::{self, Write};
use heapless::String;

/// Longest line of an answer, bytes.
pub(super) const LINE: usize = 480;
/// A line being written. Truncated at its capacity.
pub(super) type Line = String<LINE>;

/// `err CODE: why`
pub(super) fn err(code: &str, why: impl fmt::Display, out: &mut Line) {
    // a long line is truncated; nothing else can fail
    let _ = out.write_str("err ");
    for c in code.chars() {
        let _ = out.push(c.to_ascii_uppercase());
    }
    let _ = write!(out, ": {why}");
}
