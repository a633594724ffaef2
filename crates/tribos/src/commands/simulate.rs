//! `tribos simulate --model model.toml --move … --out rec.csv`

use crate::failure::{Failure, Outcome, Result};
use crate::options;
use crate::terminal::Terminal;
use crate::{files, reading};
use client::Move;
use identify::Model;
use procedures::simulated::{recording, slide_of};
use std::path::PathBuf;

/// Options of `simulate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Model written by `identify --out` or `diagnose --out`
    #[arg(long, value_name = "model.toml")]
    model: PathBuf,
    /// Motion, e.g. "sine 0.01 2 10" (m or rad, Hz, s)
    #[arg(long = "move", value_name = "WAVE AMP FREQ [SECONDS]")]
    motion: Move,
    /// Recording to write, CSV
    #[arg(long, value_name = "rec.csv")]
    out: PathBuf,
    /// Length, s, if the motion does not give it
    #[arg(long, default_value = "10", value_parser = options::seconds, allow_hyphen_values = true)]
    seconds: f64,
    /// Seed of the sensors' noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    files::check_writable(&args.out)?;
    let model = Model::read(&args.model).map_err(|e| Failure::in_file(&args.model, e))?;
    slide_of(&model).map_err(|e| Failure::in_file(&args.model, e))?;
    let recording = recording(&model, &args.motion, args.seconds, args.seed, &Terminal)?;
    reading::write_csv(&args.out, &recording)?;
    if args.out.as_os_str() != "-" {
        let seconds = args.motion.seconds.unwrap_or(args.seconds);
        println!("{}: {} samples, {seconds} s", args.out.display(), recording.len());
    }
    Ok(Outcome::Done)
}
