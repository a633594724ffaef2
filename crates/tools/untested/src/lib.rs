//! Test harness of suites that need what a clone of this repository may lack: recordings, a browser, the board's
//! compiler.
//!
//! Such a suite is a test target with `harness = false` that lists its tests:
//!
//! ```ignore
//! #[macro_use]
//! extern crate untested; // `println!` is shown only when a test fails, or with --nocapture
//!
//! fn main() -> std::process::ExitCode {
//!     untested::run!(
//!         tests![safety::the_force_goes_off, flash::a_preset_survives].needing(&TOOLCHAIN),
//!         tests![endurance::a_minute_under_full_load].needing(&TOOLCHAIN).on_demand("a minute of virtual time"),
//!     )
//! }
//! ```
//!
//! A test whose [`Need`] is missing is `ignored, <reason>`; with `CI` set it fails, unless CI is spared the need. A test that runs on demand is ignored
//! until `--ignored` or `--include-ignored` asks for it. Filters, `--exact`, `--skip`, `--list`, `--nocapture` and
//! `--test-threads` are those of the standard harness.
//!
//! A test of a rate takes its seeds from [`draws`].
//!
//! `cargo test --workspace` ends with one line for each reason: the test target `summary` of this package is the last to
//! run, and reads what the suites of the same run have left in the target directory.
#![forbid(unsafe_code)]

mod capture;
mod draws;
mod need;
mod suite;
pub mod summary;

pub use capture::print;
pub use draws::draws;
pub use need::{Need, recordings};
pub use suite::{Place, Test, Tests, run, strict};

/// Tests by their paths in the suite.
#[macro_export]
macro_rules! tests {
    ($($path:path),* $(,)?) => {
        $crate::Tests::new(vec![$($crate::Test::new(stringify!($path), $path)),*])
    };
}

/// Runs groups of [`tests!`]; the exit code of the suite.
#[macro_export]
macro_rules! run {
    ($($tests:expr),* $(,)?) => {
        $crate::run(
            &$crate::Place {
                package: env!("CARGO_PKG_NAME"),
                suite: env!("CARGO_CRATE_NAME"),
                manifest: env!("CARGO_MANIFEST_DIR"),
                file: file!(),
                scratch: env!("CARGO_TARGET_TMPDIR"),
            },
            [$($tests),*],
        )
    };
}

/// The standard macro, captured while a test runs.
#[macro_export]
macro_rules! println {
    ($($text:tt)*) => { $crate::print(format_args!("{}\n", format_args!($($text)*))) };
}
