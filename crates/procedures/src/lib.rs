//! What people do with a device, one file each. The host command prints what these return.
//!
//! ```text
//! investigate  record, diagnose, make the move that tells explanations apart, repeat
//! rendered     a real block, and the same rendered from its identification: do they feel the same?
//! simulated    a model moved by the device's own control step
//! library      the presets that ship
//! conceal      effects that can be hidden in the simulated rig
//! ```
//!
//! Nothing is printed here: progress and interruption go through [`Watch`], results and every [`Error`] to the caller.
#![forbid(unsafe_code)]

pub mod conceal;
mod error;
pub mod investigate;
pub mod library;
pub mod rendered;
pub mod simulated;
mod watch;

pub use error::Error;
pub use watch::{Activity, Unwatched, Watch, record};
