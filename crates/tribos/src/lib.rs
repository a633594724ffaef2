//! manual
#![forbid(unsafe_code)]
mod conceal;
mod failure;
mod files;
mod moves;
mod options;
mod progress;
mod raw;
mod simulated;
mod table;
pub use failure::{Failure, Outcome};
