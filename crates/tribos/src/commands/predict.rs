//! `tribos predict --model model.toml REC --out pred.csv`

use crate::failure::{Failure, Outcome, Result};
use crate::options::Mapping;
use crate::{files, reading};
use identify::Model;
use report::number::number;
use signals::Geometry;
use std::fmt::Write;
use std::path::PathBuf;

/// Options of `predict`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Model written by `identify --out` or `diagnose --out`
    #[arg(long, value_name = "model.toml")]
    model: PathBuf,
    /// Recording: CSV, .mat (v5) or .json; signals named with their units, or by --map
    #[arg(value_name = "REC")]
    recording: PathBuf,
    /// Prediction to write, CSV: time_s and force_n (torque_nm) at every sample
    #[arg(long, value_name = "pred.csv")]
    out: PathBuf,
    /// The encoder is absolute, or was homed: phases of periodic effects hold on another recording, too
    #[arg(long)]
    absolute: bool,
    #[command(flatten)]
    mapping: Mapping,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    files::check_writable(&args.out)?;
    let mut model = Model::read(&args.model).map_err(|e| Failure::in_file(&args.model, e))?;
    let recording = reading::read(&args.recording, &args.mapping)?;
    if !args.absolute && model.name != super::identify::model_name(std::slice::from_ref(&recording)) {
        let left_out = model.without_phases();
        if !left_out.is_empty() {
            eprintln!(
                "{}: {} left out: a phase along the stroke holds only while the zero of the position does; keep it with \
                 --absolute",
                args.recording.display(),
                left_out.join(", ")
            );
        }
    }
    let predicted = model.predict(&recording).map_err(Failure::new)?;
    let rotary = recording.geometry == Geometry::Rotary;
    let (name, unit) = if rotary { ("torque_nm", "N·m") } else { ("force_n", "N") };
    let mut text = format!("# predicted_by: tribos {}\n# model: {}\n", env!("CARGO_PKG_VERSION"), model.name);
    let _ = writeln!(text, "time_s,{name}");
    let (mut error, mut force, mut count) = (0.0, 0.0, 0);
    for ((t, p), f) in recording.time.iter().zip(&predicted).zip(&recording.force) {
        let _ = writeln!(text, "{t},{p}");
        if f.is_finite() && p.is_finite() {
            (error, force, count) = (error + (f - p) * (f - p), force + f * f, count + 1);
        }
    }
    files::write(&args.out, text.as_bytes())?;
    let unknown = predicted.iter().filter(|p| p.is_nan()).count();
    if unknown > 0 {
        eprintln!(
            "{}: {unknown} of {} samples are predicted as NaN: they lie in or between gaps of more than four samples, \
             and their velocity is not known",
            args.recording.display(),
            predicted.len()
        );
    }
    if args.out.as_os_str() != "-" && count > 0 && force > 0.0 {
        println!(
            "{}: {} samples; unfiltered residual {} {unit} rms, {:.2} % of the force",
            args.out.display(),
            predicted.len(),
            number((error / f64::from(count)).sqrt(), 4),
            100.0 * f64::sqrt(error / force)
        );
    }
    Ok(Outcome::Done)
}
