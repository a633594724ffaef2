//! What depends on what, read from the manifests and the `use` lines.
//!
//! ```text
//! workspace  members, their dependencies on each other, dev-dependencies included
//! source     a file without comments, strings and test modules: its imports and what it defines
//! files      which file of a crate imports which
//! circles    the strongly connected parts of any of these graphs
//! ```
//!
//! `cargo test -p architecture -- --nocapture` prints the crates in their layers with their lines of code, and fails on
//! a crate that depends on one above it or a file that circles with another.
//!
//! The reader knows Rust's paths, not its semantics: a name that a macro makes is not seen, and a method call is no
//! import. An import through a re-export counts for the file that defines the name, and a re-export alone is no import.
#![forbid(unsafe_code)]

mod circles;
mod files;
mod source;
mod workspace;

pub use circles::circles;
pub use files::{Graph, imports};
pub use workspace::{Lines, Package, packages};
