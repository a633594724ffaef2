//! An accelerometer with another scale or zero than the position says.

use super::{About, Acts, Comparison, Describe, Parameter, Quantity, Seat};
use crate::Dimension;

/// Scale and zero of an accelerometer. A force alone cannot tell it from a mass; its own channel can.
///
/// ```
/// use friction::Geometry::Linear;
/// use friction::effects::AccelerometerError;
/// use friction::effects::Describe;
///
/// let comparison = AccelerometerError::ABOUT.comparison.expect("two channels show it");
/// assert_eq!(comparison.parameters[1].unit(Linear).to_string(), "m/s²");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AccelerometerError;

impl Describe for AccelerometerError {
    const ABOUT: About = About {
        id: "accelerometer_error",
        says: "the accelerometer has another scale or zero than the position says",
        equation: "a_column = (1 + gain)·a + zero, a the second derivative of the position",
        shows: "in proportion to the acceleration, and as a trend",
        confused_with: "mass (nothing is left of it)",
        told_apart_by: "the second difference of the position",
        reads: &[Quantity::Acceleration],
        seat: Seat::Channel(Quantity::Acceleration),
        acts: Acts::OnMotion,
        bench_test: Some("compare with the second difference of the position on a faster move"),
        shown_by_motion: false,
        comparison: Some(Comparison {
            equation: "a_column = (1 + gain)·a + zero, a the second derivative of the position",
            parameters: &[
                Parameter::gain("gain", Dimension::NUMBER, (-1.0, 10.0), "what its scale has beyond 1"),
                Parameter::gain("zero", Dimension::ACCELERATION, (-1e6, 1e6), "what it shows at rest"),
            ],
            confirmed_by: "no move is needed: turn the accelerometer over in gravity, +1 g against −1 g",
        }),
        ..About::EFFECT
    };
}
