//! Every reader of tribos as a function of bytes, with what must hold whatever these are: no panic, an error of one line that names
//! the file, no memory beyond [`accepted`], and what was accepted can be used.
//!
//! `fuzz/` in the root runs each [`TARGETS`] entry under a coverage-guided fuzzer; the test of this crate runs each over its seeds,
//! the minimised corpus in `fuzz/corpus`, and every input that once failed, in `fuzz/findings`.
#![forbid(unsafe_code)]

mod device;
mod models;
mod one_line;
mod page;
mod recordings;
mod seeds;

pub use seeds::{Seed, seeds};

use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATED: PeakAlloc = PeakAlloc;

/// A reader and its name.
pub type Target = (&'static str, fn(&[u8]));

/// All readers.
pub const TARGETS: [Target; 13] = [
    ("csv", recordings::csv),
    ("json", recordings::json),
    ("mat5", recordings::mat5),
    ("hdf5", recordings::hdf5),
    ("mcap", recordings::mcap),
    ("bag", recordings::bag),
    ("parquet", recordings::parquet),
    ("model", models::model),
    ("preset", models::preset),
    ("console", device::console),
    ("frame", device::frame),
    ("flash", device::flash),
    ("page", page::message),
];

/// Memory bound per byte of input, bytes.
const MOST: usize = 20;
/// Memory that a small input may take, bytes.
const LEAST: usize = 4 << 20;

/// Memory that a reader may take for an input of `bytes`, bytes.
#[must_use]
pub fn accepted(bytes: usize) -> usize {
    LEAST + MOST * bytes
}

/// Runs the reader of this name. Returns the memory it took at most, bytes.
///
/// # Panics
/// Something does not hold; or the name is unknown.
pub fn run(name: &str, bytes: &[u8]) -> usize {
    let (_, target) = TARGETS.iter().find(|(target, _)| *target == name).expect("a target of this name");
    let before = ALLOCATED.current_usage();
    ALLOCATED.reset_peak_usage();
    target(bytes);
    let taken = ALLOCATED.peak_usage().saturating_sub(before);
    assert!(taken <= accepted(bytes.len()), "{name}: an input of {} bytes allocates {taken}", bytes.len());
    taken
}
