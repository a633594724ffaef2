//! The `tribos` command. The library has the code and the manual.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    // a reader that has enough, as `head`, ends the command; printing would panic
    sigpipe::reset();
    let cli = tribos::Cli::parse();
    match tribos::run(&cli) {
        Ok(outcome) => outcome.into(),
        Err(failure) => {
            failure.print();
            failure.exit_code()
        }
    }
}
