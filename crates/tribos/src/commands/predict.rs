//! `tribos predict --model model.toml REC --out pred.csv`

use crate::failure::{Failure, Outcome, Result};
use crate::options::Mapping;
use crate::{files, reading};
use identify::Model;
use identify::planar::PlanarModel;
use procedures::planar::{self, Recordings};
use procedures::predicted::predict;
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
    /// Recording: text, .mat, .json, .h5, .parquet, .mcap, a ROS 2 bag; signals named with their units, or by --map
    #[arg(value_name = "REC")]
    recording: PathBuf,
    /// Prediction to write, CSV: time_s, force_n (torque_nm) and its standard deviation force_std_n (torque_std_nm) at every
    /// sample
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
    if std::fs::read_to_string(&args.model).is_ok_and(|text| PlanarModel::is_planar(&text)) {
        return in_the_plane(args);
    }
    let model = Model::read(&args.model).map_err(|e| Failure::in_file(&args.model, e))?;
    let recording = reading::read(&args.recording, &args.mapping)?;
    let predicted = predict(&model, &recording, args.absolute)?;
    for note in &predicted.notes {
        eprintln!("{}: {note}", args.recording.display());
    }
    let rotary = recording.geometry == Geometry::Rotary;
    let (name, std_name, unit) =
        if rotary { ("torque_nm", "torque_std_nm", "N·m") } else { ("force_n", "force_std_n", "N") };
    let mut text = format!("# predicted_by: tribos {}\n# model: {}\n", env!("CARGO_PKG_VERSION"), model.name);
    let _ = writeln!(text, "time_s,{name},{std_name}");
    for ((t, p), std) in recording.time.iter().zip(&predicted.force).zip(&predicted.std) {
        let _ = writeln!(text, "{t},{p},{std}");
    }
    files::write(&args.out, text.as_bytes())?;
    if args.out.as_os_str() != "-" {
        print!("{}", predicted.errors.words(&args.out.display().to_string(), unit));
    }
    Ok(Outcome::Done)
}

fn in_the_plane(args: &Args) -> Result<Outcome> {
    let model = PlanarModel::read(&args.model).map_err(|e| Failure::in_file(&args.model, e))?;
    let recording = match reading::read_any(&[&args.recording], &args.mapping)? {
        Recordings::Plane(mut recordings) => recordings.swap_remove(0),
        Recordings::Line(_) => {
            let model = args.model.display();
            let why =
                format!("{}: is on a line, and {model} is a model in the plane", args.recording.display());
            return Err(Failure::new(why)
                .help("accepted is a recording with position_x_m, position_y_m, force_x_n and force_y_n"));
        }
    };
    let predicted = planar::predict(&model, &recording)?;
    let mut text = format!("# predicted_by: tribos {}\n# model: {}\n", env!("CARGO_PKG_VERSION"), model.name);
    text += "time_s,force_x_n,force_y_n\n";
    let [x, y] = &predicted.force;
    for ((t, x), y) in predicted.time.iter().zip(x).zip(y) {
        let _ = writeln!(text, "{t},{x},{y}");
    }
    files::write(&args.out, text.as_bytes())?;
    if args.out.as_os_str() != "-" {
        println!(
            "{}: error {} N rms where the body slides, {:.2} % of the force",
            args.out.display(),
            number(predicted.error, 3),
            100.0 * predicted.relative
        );
    }
    Ok(Outcome::Done)
}
