//! A cable that rubs on what it is bent around.

use super::{About, Describe, Quantity, Seat};

/// Presliding over a millimetre and more, in the transmission. A diagnosis names [`Presliding`](super::Presliding), whose
/// distance says which it is.
///
/// ```
/// use friction::effects::{CableHysteresis, Describe, Presliding};
///
/// assert_eq!(CableHysteresis::ABOUT.case_of, Some(Presliding::ABOUT.id));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CableHysteresis;

impl Describe for CableHysteresis {
    const ABOUT: About = About {
        id: "cable_hysteresis",
        says: "A cable gives before it follows, over a distance that can be seen.",
        equation: "force*(z - s), dz/dx = (1 - s*z)/x_s, x_s about 1 mm",
        shows: "a long lobe after a reversal",
        confused_with: "presliding, backlash",
        told_apart_by: "a position measured on the load",
        reads: &[Quantity::Displacement, Quantity::Velocity],
        seat: Seat::Drive,
        case_of: Some("presliding"),
        ..About::EFFECT
    };
}
