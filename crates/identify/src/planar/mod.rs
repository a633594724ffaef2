//! Friction in the plane, identified from recordings of two axes.
//!
//! F = M a + G v/√(vᵀGv) + B v + F₀: the axes are rows of one regression, x above y, and share what both feel. The model
//! is a [`PlanarModel`], whose law is one of [`friction::planar`].

mod ellipse;
mod fit;
mod model;
mod track;

pub use ellipse::Ellipse;
pub use fit::{ELLIPSE, PlanarIdentified, PlanarOptions, identify_planar};
pub use model::{PLANAR_MODEL_SCHEMA, PlanarModel};
pub use track::Track;
