//! The page without installation: a recording is dropped on it, `identify` and `diagnose` run in the browser, and nothing leaves
//! the machine.
//!
//! ```text
//! analysis    options as people type them, recordings, results: report, JSON, model
//! bindings    the same for JavaScript, in a worker
//! assets/     the page and its worker; `src/bin/one-file.rs` puts everything into one file
//! ```
//!
//! The page says what the command says, in its words: both call `procedures`.
#![forbid(unsafe_code)]

mod analysis;
#[cfg(target_arch = "wasm32")]
mod bindings;

pub use analysis::{Analysis, Answer, Options, Refusal};
