//! What has no name.

use super::{About, Describe, Seat};

/// Something that repeats and that no effect of the catalogue explains.
///
/// ```
/// use friction::effects::{Describe, Unnamed};
///
/// assert!(Unnamed::ABOUT.gains.is_empty()); // its shape is in the data
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unnamed;

impl Describe for Unnamed {
    const ABOUT: About = About {
        id: "unnamed",
        says: "Something repeats that no law of the catalogue fits.",
        equation: "a curve over the coordinate where it sits",
        shows: "where the diagnosis locates it",
        told_apart_by: "the same move at another amplitude and another frequency",
        seat: Seat::Unknown,
        ..About::EFFECT
    };
}
