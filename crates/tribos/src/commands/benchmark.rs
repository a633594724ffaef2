//! `tribos benchmark emps|silverbox --data DIR`: public benchmarks by their official protocols.

use crate::failure::{Outcome, Result};
use crate::files;
use crate::progress::Progress;
use benchmark::{emps, silverbox};
use std::path::{Path, PathBuf};

/// Options of `benchmark`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Which benchmark
    #[arg(value_enum)]
    benchmark: Benchmark,
    /// Folder of the official files: DATA_EMPS.mat and DATA_EMPS_PULSES.mat, or SNLS80mV.mat or .csv
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// Refit the model without each of its terms, and tell what each gains on training data that was held out
    #[arg(long)]
    gains: bool,
    /// Model, figures and rivals as JSON; `-` is standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// The benchmarks.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Benchmark {
    /// A motor and a ball screw with friction; free run in open loop, mm
    Emps,
    /// An electronic Duffing oscillator; free run, mV
    Silverbox,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    if let Some(path) = &args.json {
        files::check_writable(path)?;
    }
    let bar = Progress::new("benchmark");
    let progress = |share: f32, what: &str| bar.set(share, what);
    let answer = match args.benchmark {
        Benchmark::Emps => emps::run(&args.data, args.gains, &progress),
        Benchmark::Silverbox => silverbox::run(&args.data, args.gains, &progress),
    }?;
    drop(bar);
    if let Some(path) = &args.json {
        files::write_json(path, &answer)?;
    }
    if args.json.as_deref() != Some(Path::new("-")) {
        print!("{}", answer.describe());
    }
    Ok(Outcome::Done)
}
