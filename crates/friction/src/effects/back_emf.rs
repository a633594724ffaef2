//! The voltage that a turning motor makes against its supply.

use super::{About, Describe, Quantity, Seat, Twin};

/// Braking by the motor's own voltage, F = K_t·K_e·v/R: viscous friction in every motion.
///
/// ```
/// use friction::effects::{BackEmf, Describe};
///
/// assert_eq!(BackEmf::ABOUT.twin.expect("no motion separates them").of.len(), 2); // either direction's viscous friction
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BackEmf;

impl Describe for BackEmf {
    const ABOUT: About = About {
        id: "back_emf",
        says: "The motor brakes itself by the voltage it makes while it moves.",
        equation: "K_t*K_e*v/R",
        shows: "in proportion to the velocity",
        confused_with: "viscous friction: identical",
        told_apart_by: "open and shorted winding",
        reads: &[Quantity::Velocity],
        opposes_motion: true,
        seat: Seat::Drive,
        bench_test: Some("open and short the winding while the slide is pushed: motion alone cannot tell"),
        shown_by_motion: false,
        twin: Some(Twin {
            of: &["viscous_p", "viscous_n"],
            because: "identical to viscous friction in every motion",
        }),
        ..About::EFFECT
    };
}
