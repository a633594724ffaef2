//! Friction that depends on the direction of motion in the plane.

use super::{About, Describe, Parameter, Quantity, Scale};
use crate::Dimension;

/// A grain: the level of friction is an ellipse, as [`planar::Grain`](crate::planar::Grain) has it. Only a recording in the plane
/// shows it.
///
/// ```
/// use friction::effects::{Anisotropy, Describe};
///
/// let names: Vec<&str> = Anisotropy::ABOUT.parameters().map(|p| p.name).collect();
/// assert_eq!(names, ["ratio", "angle"]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Anisotropy;

impl Describe for Anisotropy {
    const ABOUT: About = About {
        id: "anisotropy",
        says: "Friction is larger in one direction of the plane than across it, and does not quite point against the motion.",
        equation: "level*G*v/sqrt(v*G*v), G = 1 along the angle and ratio^2 across it",
        shows: "two periods in a turn of the direction of motion, along the motion and across it",
        confused_with: "a mass, a zero or a viscous coefficient that differs between the axes, where the motion has few directions",
        told_apart_by: "lines in several directions, to and fro, at several speeds",
        shape: &[
            Parameter::shape("ratio", Scale::Range, (1.0, 100.0), "friction across the grain over friction along it"),
            Parameter {
                name: "angle",
                dimension: Dimension::PHASE,
                scale: Scale::Range,
                min: -core::f64::consts::PI,
                max: core::f64::consts::PI,
                what: "angle of the grain with the x axis",
            },
        ],
        reads: &[Quantity::Velocity],
        opposes_motion: true,
        ..About::EFFECT
    };
}
