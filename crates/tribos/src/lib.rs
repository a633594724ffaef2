//! The host command of tribos: moves and records a device, identifies its friction, finds missing physics, predicts and
//! simulates.
//!
//! ```text
//! commands/   one file per subcommand: options, one call, output
//! options     shared options
//! failure     one-line errors and exit codes
//! terminal    progress bars and Ctrl-C
//! console     the full-screen console of `connect`
//! reading     recordings from files, with `--map`
//! lab_tools   services for the browser page
//! ```
//!
//! A failure is one line with file, line and column, or option, the value, and what would be accepted ([`Failure`], exit code 2).
//! A missing finding of `--expect` is exit code 1.
#![forbid(unsafe_code)]

mod cli;
mod commands;
mod console;
mod failure;
mod files;
mod lab_tools;
mod live;
mod options;
mod progress;
mod reading;
mod terminal;

pub use cli::{Cli, run};
pub use failure::{Failure, Outcome};
