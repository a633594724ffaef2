//! The report: one HTML file that a person would rather look at than the JSON.
//!
//! Self-contained (no network: style, script, uPlot and data are inlined), light and dark, printable, and
//! readable on a telephone. First the sentence, then the picture that convinces, then everything that
//! qualifies it: intervals, rivals, what was ruled out, what this recording cannot show, what to record next,
//! and how the figures were computed.

mod chart;
mod diagnosis;
mod identification;
mod page;
mod tables;
mod text;

#[cfg(test)]
mod tests;

pub use diagnosis::html;
pub use identification::{Identified, Undetermined, identification_html};
