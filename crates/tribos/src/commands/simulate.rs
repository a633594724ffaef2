//! `tribos simulate --model model.toml --move … --out rec.csv`

use crate::failure::{Failure, Outcome, Result};
use crate::options;
use crate::terminal::Terminal;
use crate::{files, reading};
use client::{Move, Sample};
use identify::Model;
use plant::Layered;
use procedures::simulated::{Slide, simulate};
use signals::{Geometry, Recording};
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
    let mut slide: Slide =
        Layered::with(model.law, &model.effects).map_err(|e| Failure::in_file(&args.model, e))?;
    for curve in &model.curves {
        slide.add_curve(*curve).map_err(|e| Failure::in_file(&args.model, e))?;
    }
    let seconds = args.motion.seconds.unwrap_or(args.seconds);
    let (points, calibration) = simulate(slide, model.mass, &args.motion, seconds, args.seed, &Terminal)?;
    let column = |f: fn(&Sample) -> f64| points.iter().map(f).collect::<Vec<f64>>();
    let start = points.first().map_or(0.0, |p| p.time);
    let offset = model.nuisances.offset;
    let mut recording = Recording {
        name: args.out.display().to_string(),
        geometry: model.geometry,
        time: points.iter().map(|p| p.time - start).collect(),
        position: column(|p| p.position),
        force: points.iter().map(|p| p.force + offset).collect(),
        velocity: Some(column(|p| p.velocity)),
        acceleration: Some(column(|p| p.acceleration)),
        ..Recording::default()
    };
    if model.geometry == Geometry::Linear {
        recording.command = Some(column(|p| p.command));
        recording.reference = Some(column(|p| p.reference));
    }
    for (key, value) in [
        ("simulated_by", format!("tribos {}", env!("CARGO_PKG_VERSION"))),
        ("model", model.name.clone()),
        ("move", args.motion.to_string()),
        ("seed", args.seed.to_string()),
        ("newton_per_code", calibration.load_unit.to_string()),
    ] {
        recording.metadata.insert(key.into(), value);
    }
    reading::write_csv(&args.out, &recording)?;
    if args.out.as_os_str() != "-" {
        println!("{}: {} samples, {seconds} s", args.out.display(), recording.len());
    }
    Ok(Outcome::Done)
}
