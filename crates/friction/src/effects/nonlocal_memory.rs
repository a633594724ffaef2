//! Friction that remembers more than the last reversal.

use super::{About, Describe, Quantity};

/// Nested loops, as of several bristles side by side ([`MaxwellSlip`](crate::MaxwellSlip)). A diagnosis names
/// [`Presliding`](super::Presliding), which is one of them.
///
/// ```
/// use friction::effects::{Describe, NonlocalMemory, Presliding};
///
/// assert_eq!(NonlocalMemory::ABOUT.case_of, Some(Presliding::ABOUT.id));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NonlocalMemory;

impl Describe for NonlocalMemory {
    const ABOUT: About = About {
        id: "nonlocal_memory",
        says: "After a reversal friction follows a loop inside the loop before it.",
        equation: "sum of force_i*(z_i - s), dz_i/dx = (1 - s*z_i)/x_i",
        shows: "nested loops after shrinking reversals",
        confused_with: "presliding, cable_hysteresis",
        told_apart_by: "shrinking reversals",
        reads: &[Quantity::Displacement, Quantity::Velocity],
        case_of: Some("presliding"),
        ..About::EFFECT
    };
}
