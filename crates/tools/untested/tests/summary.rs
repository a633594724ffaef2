//! The last test target of `cargo test --workspace`: one line for each reason why tests were skipped.

use std::path::Path;
use untested::summary;

fn main() {
    let suites = summary::collect(Path::new(env!("CARGO_TARGET_TMPDIR")));
    print!("{}", summary::lines(&suites));
}
