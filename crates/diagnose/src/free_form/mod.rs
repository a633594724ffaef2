//! Physics without a name: smooth curves and maps over coordinates of the motion, fitted to what the catalogue leaves and
//! judged as effects are.

pub mod candidate;
pub mod change;
pub mod contradiction;
pub mod crossing;
pub mod describe;
pub mod finding;
pub mod formula;
pub mod hum;
pub mod switching;
pub mod term;
