//! `cargo run --release -p emulator -- run|record|report`: the firmware's ELF on the emulated board.
#![forbid(unsafe_code)]

mod command;
// the same serial line as the virtual device's
#[path = "../../../../src/virtual_device/pty.rs"]
mod pty;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// The very ELF that would be flashed, on an emulated NUCLEO-G474RE around the simulated rig.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The board in real time, its serial line on a pseudo-terminal for `tribos connect|record|identify`
    Run(command::run::Args),
    /// A run with everything that the core read and wrote, for another emulator
    Record(command::record::Args),
    /// Figures of the firmware under full load, against their bars
    Report(command::report::Args),
}

fn main() -> ExitCode {
    let ended = match &Cli::parse().command {
        Command::Run(args) => command::run::run(args),
        Command::Record(args) => command::record::run(args),
        Command::Report(args) => command::report::run(args),
    };
    ended.unwrap_or_else(|why| {
        eprintln!("error: {why}");
        ExitCode::from(2)
    })
}
