//! Pages, charts, pictures, tables and numbers for people. This crate computes no results.
//!
//! ```text
//! number      a value to the digits of its standard error, as text or HTML
//! table       aligned columns for the terminal
//! picture     panels of lines, points and coloured cells as SVG: the only drawer of pictures
//! chart       what uPlot draws inside a page: zoom, cursor, light and dark
//! page        one self-contained HTML file (style, script, data inlined; nothing is fetched)
//!
//! identification  diagnosis  overlay  sessions      what each result shows, built from the above
//! ```
//!
//! A page begins with one sentence and the main picture, followed by qualifications: intervals, rivals, excluded effects, limits
//! of the recording, the next experiment, and the computation of the figures.
//!
//! ```
//! use report::number;
//! assert_eq!(number::with_std(95.1543, 0.0831), ("95.154".into(), "0.083".into()));
//! assert_eq!(number::number(2.57e-6, 3), "2.57e-6");
//! ```
#![forbid(unsafe_code)]

mod chart;
mod compensation;
mod diagnosis;
mod escape;
mod fragments;
mod identification;
pub mod number;
mod overlay;
pub mod page;
pub mod picture;
mod planar;
mod sessions;
mod sessions_pictures;
mod table;

#[cfg(test)]
mod tests;

pub use compensation::{Compensated, compensation};
pub use diagnosis::diagnosis;
pub use escape::escape;
pub use fragments::Undetermined;
pub use identification::{Identified, identification};
pub use overlay::{overlay, planar_overlay};
pub use planar::{PlanarIdentified, planar_identification};
pub use sessions::{sessions, threshold};
pub use table::Table;
