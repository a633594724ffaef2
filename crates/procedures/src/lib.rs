//! What people do with recordings and with a device, one file each. The host command and the Python package show what these
//! return.
//!
//! ```text
//! recordings   files by the map each needs; several as one
//! identified   a fit, its model and its report
//! diagnosed    what a diagnosis is asked with
//! predicted    the force of a recording by a model
//! investigate  record, diagnose, make the move that tells explanations apart, repeat
//! rendered     a real block, and the same rendered from its identification: do they feel the same?
//! compensated  what was found of a device, fed forward on it: before and after
//! simulated    a model moved by the device's own control step
//! library      the presets that ship
//! numbers      what people type, and what is accepted
//! conceal      effects that can be hidden in the simulated rig
//! ```
//!
//! Without the feature `device` what moves, records or simulates one is not there; the rest runs in a browser.
//!
//! Nothing is printed here: progress and interruption go through [`Watch`], results and every [`Error`] to the caller.
#![forbid(unsafe_code)]

#[cfg(feature = "device")]
pub mod compensated;
pub mod conceal;
pub mod diagnosed;
mod error;
pub mod identified;
#[cfg(feature = "device")]
pub mod investigate;
pub mod library;
pub mod numbers;
#[cfg(feature = "device")]
mod own_friction;
pub mod planar;
pub mod predicted;
mod prediction_errors;
pub mod recordings;
#[cfg(feature = "device")]
pub mod rendered;
#[cfg(all(test, feature = "device"))]
mod rendered_textures;
#[cfg(feature = "device")]
pub mod simulated;
mod watch;

pub use error::Error;
pub use prediction_errors::PredictionErrors;
#[cfg(feature = "device")]
pub use watch::record;
pub use watch::{Activity, Unwatched, Watch};
