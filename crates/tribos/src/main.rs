//! The `tribos` command; everything it does is in the library, see its page for the manual.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = tribos::Cli::parse();
    match tribos::run(&cli) {
        Ok(outcome) => outcome.into(),
        Err(failure) => {
            failure.print();
            failure.exit_code()
        }
    }
}
