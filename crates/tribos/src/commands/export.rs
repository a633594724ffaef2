//! `tribos export mujoco|urdf|modelica|bam --model model.toml`

use crate::failure::{Failure, Outcome, Result};
use crate::options::Mapping;
use crate::{files, reading};
use clap::ValueEnum;
use identify::Model;
use std::path::PathBuf;

/// Format of a simulator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// MJCF of MuJoCo: damping, friction loss, a linear spring; presliding, friction that falls with the speed, cogging and gravity by
    /// a `dcmotor` without input (MuJoCo 3.12)
    Mujoco,
    /// URDF: damping, friction, limits as recorded
    Urdf,
    /// Modelica, of components of its standard library 4: break-away, tables over the speed and over the recorded stroke, a spring,
    /// a constant force
    Modelica,
    /// JSON of BAM: friction of an axis that falls with the speed and grows with the torque (M1 to M4). M5 and M6 are
    /// never written: they tell friction in front of the gears from friction behind them, which one torque cannot
    Bam,
}

impl From<Format> for export::Format {
    fn from(format: Format) -> Self {
        match format {
            Format::Mujoco => Self::Mujoco,
            Format::Urdf => Self::Urdf,
            Format::Modelica => Self::Modelica,
            Format::Bam => Self::Bam,
        }
    }
}

/// Options of `export`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[arg(value_enum)]
    format: Format,
    /// Model written by `identify --out` or `diagnose --out`
    #[arg(long, value_name = "model.toml")]
    model: PathBuf,
    /// File to write, `-` for standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    /// Recording that shows how much force is lost by what the format cannot hold
    #[arg(long, value_name = "REC")]
    recording: Option<PathBuf>,
    #[command(flatten)]
    mapping: Mapping,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    files::check_writable(&args.out)?;
    if args.recording.is_none() && !args.mapping.maps.is_empty() {
        return Err(Failure::new("--map: there is no recording; accepted with --recording"));
    }
    let model = Model::read(&args.model).map_err(|e| Failure::in_file(&args.model, e))?;
    let recording = args.recording.as_ref().map(|path| reading::read(path, &args.mapping)).transpose()?;
    let exported = export::export(&model, args.format.into(), recording.as_ref()).map_err(|e| match e {
        export::Error::Recording(e) => Failure::new(e),
        export::Error::NoLimits => Failure::in_file(&args.model, e).help("--recording gives them"),
        e @ (export::Error::Parameter { .. } | export::Error::NotAnAxis) => Failure::in_file(&args.model, e),
    })?;
    files::write(&args.out, exported.text.as_bytes())?;
    // standard output belongs to the file
    for line in exported.lines() {
        eprintln!("{}: not held: {line}", args.model.display());
    }
    Ok(Outcome::Done)
}
