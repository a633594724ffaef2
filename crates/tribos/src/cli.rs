//! The command line as a whole.

use crate::commands::{
    benchmark, compare, compensate, connect, convert, demo, design, design_args, diagnose, experiment,
    export, figures, identify, investigate, lab, predict, preset, prove, record, simulate,
};
use crate::failure::{Outcome, Result};
use clap::{Parser, Subcommand};

/// Records real sliding, identifies its friction, and finds the physics a simulation left out.
#[derive(Debug, Parser)]
#[command(name = "tribos", version, about, propagate_version = true, disable_help_subcommand = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The whole story on the virtual device, without hardware, in under a minute
    Demo(demo::Args),
    /// A console on a device, with a live plot
    Connect(connect::Args),
    /// A page in the browser: live scope, presets, experiments
    Lab(lab::Args),
    /// Move a device and record it
    Record(record::Args),
    /// Identify mass and friction from recordings
    Identify(identify::Args),
    /// Find out where a simulation goes wrong on recordings, and what physics it left out
    Diagnose(diagnose::Args),
    /// Diagnose, run the experiment that separates the remaining explanations, repeat
    Investigate(investigate::Args),
    /// Compare a rendered block with a real one, in just noticeable differences
    Compare(compare::Args),
    /// Feed forward what was found of a device itself, friction and cogging, and measure what the hand feels then
    Compensate(compensate::Args),
    /// Predict the force of a recording with a model
    Predict(predict::Args),
    /// Move a simulated rig with a model's friction and record it
    Simulate(simulate::Args),
    /// Write a model for a simulator, and say what its format cannot hold
    Export(export::Args),
    /// Presets: the library, a device's, files
    Preset(preset::Args),
    /// Stability bounds and limit cycles of a rendered block, before anything runs
    Design(design_args::Args),
    /// Redraw the figures of Richard's thesis, with its numbers beside ours
    Figures(figures::Args),
    /// The perception experiments: analyse sessions, simulate subjects
    Experiment(experiment::Args),
    /// Prove on sealed recordings that concealed effects are found, and nothing else
    Prove(prove::Args),
    /// Run a public benchmark of system identification by its official protocol, beside published rivals
    Benchmark(benchmark::Args),
    /// Convert a recording between text, MATLAB, HDF5, Parquet and MCAP, or from a ROS 2 bag
    Convert(convert::Args),
}

/// Runs the command.
///
/// # Errors
/// Bad usage or bad input, exit code 2; nothing half-written is left behind.
pub fn run(cli: &Cli) -> Result<Outcome> {
    match &cli.command {
        Command::Demo(args) => demo::run(args),
        Command::Connect(args) => connect::run(args),
        Command::Lab(args) => lab::run(args),
        Command::Record(args) => record::run(args),
        Command::Identify(args) => identify::run(args),
        Command::Diagnose(args) => diagnose::run(args),
        Command::Investigate(args) => investigate::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Compensate(args) => compensate::run(args),
        Command::Predict(args) => predict::run(args),
        Command::Simulate(args) => simulate::run(args),
        Command::Export(args) => export::run(args),
        Command::Preset(args) => preset::run(args),
        Command::Design(args) => design::run(args),
        Command::Figures(args) => figures::run(args),
        Command::Experiment(args) => experiment::run(args),
        Command::Prove(args) => prove::run(args),
        Command::Benchmark(args) => benchmark::run(args),
        Command::Convert(args) => convert::run(args),
    }
}
