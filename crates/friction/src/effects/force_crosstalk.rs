//! A load cell that feels acceleration and position.

use super::{About, Acts, Describe, Quantity, Seat, Twin};

/// Acceleration and position in the load cell, F + k·a + k'·x: a mass and a spring in every motion.
///
/// ```
/// use friction::effects::{Describe, ForceCrosstalk};
///
/// assert_eq!(ForceCrosstalk::ABOUT.twin.expect("no motion separates them").of, ["mass", "spring"]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ForceCrosstalk;

impl Describe for ForceCrosstalk {
    const ABOUT: About = About {
        id: "force_crosstalk",
        says: "The load cell shows acceleration or position as if they were force.",
        equation: "k_a*a + k_x*x",
        shows: "in proportion to the acceleration and to the position",
        confused_with: "mass, spring: never separable by motion",
        told_apart_by: "weights, and shaking the free load cell",
        reads: &[Quantity::Acceleration, Quantity::Position],
        seat: Seat::Channel(Quantity::Force),
        acts: Acts::OnForce,
        bench_test: Some("hang weights, then shake the free load cell: motion alone cannot tell"),
        shown_by_motion: false,
        twin: Some(Twin { of: &["mass", "spring"], because: "identical to a mass and a spring in every motion" }),
        ..About::EFFECT
    };
}
