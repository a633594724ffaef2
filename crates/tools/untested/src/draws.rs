//! How often a test of a rate draws.

use std::env;
use std::ops::Range;

/// Seeds of a test that counts how often something comes out right: `few`, which notice what went wrong; with
/// `TRIBOS_TESTS=all` in the environment all, which measure how often.
///
/// ```
/// let counted = untested::draws(2, 20).count();
/// assert!(counted == 2 || counted == 20);
/// ```
#[must_use]
pub fn draws(few: u64, all: u64) -> Range<u64> {
    let asked = env::var_os("TRIBOS_TESTS").is_some_and(|which| which == "all");
    0..if asked { all } else { few }
}
