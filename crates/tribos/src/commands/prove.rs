//! `tribos prove`: the concealed-effect proof.

use crate::failure::{Failure, Outcome, Result};
use crate::files;
use crate::progress::Progress;
use ::prove::{Extent, NOISE, Run};
use std::path::PathBuf;
use std::time::Instant;

/// Options of `prove`.
#[derive(Debug, clap::Args)]
#[command(long_about = "\
The concealed-effect proof: recordings of a plant that shares no equation with the diagnosis, with one effect hidden, or \
two, or none, or only a fault of the recording. Every recording is diagnosed before the folder `sealed` with the labels is \
opened. The order is drawn, so those that `--minutes` leaves time for are a fair sample; once the labels are open no answer is added.

Strengths are times the noise: the root mean square, while sliding, of the force that the effect adds and that mass, \
Coulomb and viscous friction of each direction cannot absorb, over the standard deviation of one force sample. At 1 the \
effect has the size of the noise of a single sample.")]
pub struct Args {
    /// Recordings of each effect at each strength; ten times as many with nothing hidden
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    seeds: u64,
    /// Seed of every draw: plants, motions, noise and order
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Strengths, in multiples of the noise
    #[arg(long, value_name = "X,…", value_delimiter = ',', default_value = "0.3,1,2,5", value_parser = strength, allow_hyphen_values = true)]
    strengths: Vec<f64>,
    /// Hide only these effects; by default the whole catalogue, pairs and recording faults
    #[arg(long, value_name = "EFFECT,…", value_delimiter = ',')]
    effects: Vec<String>,
    /// Folder for recordings, answers and labels; the same options continue a proof that was interrupted
    #[arg(long, value_name = "DIR", default_value = "tribos-proof")]
    out: PathBuf,
    /// Write the tables as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Open the labels after this number of minutes, even if some recordings are not diagnosed
    #[arg(long, value_name = "MINUTES", value_parser = minutes, allow_hyphen_values = true)]
    minutes: Option<f64>,
    /// Hide what is in nobody's catalogue: random smooth functions, and what machines do. Right is `unnamed`
    #[arg(long)]
    open: bool,
    /// Three effects at 5 times the noise, once each, on short recordings
    #[arg(long)]
    quick: bool,
}

fn strength(text: &str) -> std::result::Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if (0.05..=100.0).contains(&x) => Ok(x),
        _ => Err("a number from 0.05 to 100, times the noise, is accepted".into()),
    }
}

fn minutes(text: &str) -> std::result::Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if (0.0..=1e5).contains(&x) => Ok(x),
        _ => Err("a number from 0 to 100000 is accepted".into()),
    }
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    if let Some(path) = &args.json {
        files::check_writable(path)?;
    }
    let known = if args.open { ::prove::open_effects() } else { ::prove::effects() };
    if let Some(unknown) = args.effects.iter().find(|e| !known.contains(&e.as_str())) {
        return Err(Failure::new(format!("--effects: `{unknown}` cannot be hidden"))
            .help(format!("accepted are {}", known.join(", "))));
    }
    let extent = extent(args);
    let seconds = extent.seconds;
    let run = Run::begin(&args.out, extent)?;
    let (count, quiet) = (run.count(), args.json.as_deref() == Some(std::path::Path::new("-")));
    if !quiet {
        println!(
            "{count} recordings of {seconds} s, noise of a force sample {NOISE} N{}",
            if run.is_continued() { ", continued" } else { "" }
        );
    }
    let bar = Progress::new("sealing recordings");
    let progress = |what: &str, done: usize, of: usize| {
        bar.set(done as f32 / of.max(1) as f32, &format!("{what}: {done} of {of}"));
    };
    run.seal(&progress)?;
    let begun = Instant::now();
    run.answer(|| args.minutes.is_none_or(|m| begun.elapsed().as_secs_f64() < 60.0 * m), &progress)?;
    let (proof, answered) = run.open_labels(&progress)?.ok_or_else(|| {
        Failure::new("no recording was answered").help("give it more --minutes and another --out")
    })?;
    drop(bar);
    if let Some(path) = &args.json {
        files::write_json(path, &proof)?;
    }
    if !quiet {
        if answered < count {
            println!("{answered} of {count} were answered in time, in an order that was drawn");
        }
        print!("{}", proof.describe());
        println!(
            "\n  {}: recordings, answers, labels, prove.json, cases.csv, confusion.csv",
            args.out.display()
        );
    }
    Ok(Outcome::Done)
}

fn extent(args: &Args) -> Extent {
    let mut effects = args.effects.clone();
    if args.quick && effects.is_empty() && !args.open {
        effects = ["spring", "cogging", "quadratic_drag"].map(String::from).to_vec();
    }
    Extent {
        seeds: if args.quick { 1 } else { args.seeds },
        seed: args.seed,
        strengths: if args.quick { vec![5.0] } else { args.strengths.clone() },
        seconds: if args.quick { 8.0 } else { 16.0 },
        companions: effects.is_empty() && !args.open,
        open: args.open,
        effects,
    }
}
