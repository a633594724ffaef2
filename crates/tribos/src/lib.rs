//! The host command of tribos: moves a device and records it, identifies its friction, finds the physics a simulation
//! left out, predicts and simulates with what was found.
//!
//! ```text
//! commands/   one file a subcommand
//! library     the presets that come with the program
//! session     a conversation with a device   ── wire (bytes to items) ── transport (port, or virtual device)
//! recorder    a device's stream into a CSV that survives a crash
//! reading     recordings from files
//! compare     two recordings, one distance in just noticeable differences
//! investigate record, diagnose, choose the next move, repeat
//! simulated   a model moved by the very control step of the device
//! console     the full-screen console of `connect`
//! ```
//!
//! Every failure is one line that names file, line and column or option, the value found and what would be accepted
//! ([`Failure`], exit code 2); a finding asked for with `--expect` that is not there is exit code 1.
#![forbid(unsafe_code)]

mod cli;
mod columns;
mod commands;
mod compare;
mod conceal;
mod console;
mod design;
mod experiment;
mod failure;
mod figures;
mod files;
mod investigate;
mod lab_tools;
mod library;
mod mat_file;
mod mcap_file;
mod moves;
mod options;
mod progress;
mod prove;
mod raw;
mod reading;
mod recorder;
mod session;
mod simulated;
mod table;
mod transport;
mod wire;

pub use cli::{Cli, run};
pub use failure::{Failure, Outcome};
