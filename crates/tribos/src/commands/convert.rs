//! `tribos convert IN OUT`

use crate::failure::{Failure, Outcome, Result};
use crate::options::Mapping;
use crate::{files, reading};
use std::path::PathBuf;

/// File formats, for `--help`.
const FORMATS: &str = "\
File formats, recognised by content, then by suffix:
  text       in, out   .csv; cells separated by commas, semicolons, tabs or spaces;
                       units in a second line; decimal commas where commas separate no cells
  MATLAB     in, out   .mat of version 5 to 7, in also 7.3
  JSON       in        .json, a list of samples or columns
  HDF5       in, out   .h5
  Parquet    in, out   .parquet
  MCAP       in, out   .mcap; in: of tribos, of ROS 2, numbers of JSON messages
  ROS 2 bag  in        its folder, .db3 or .mcap; sensor_msgs/JointState and
                       geometry_msgs/WrenchStamped

Examples:
  tribos convert rec.csv rec.parquet
  tribos convert bag/ elbow.csv --joint elbow
  tribos convert bag/ slide.csv --joint slider --map force_n=/ft:force.z
  tribos convert log.h5 j2.csv --joint 2 --map time_s=t,position_rad=q,torque_nm=tau";

/// Options of `convert`.
#[derive(Debug, clap::Args)]
#[command(after_help = FORMATS)]
pub struct Args {
    /// Recording to read: text, .mat, .json, .h5, .parquet, .mcap, a ROS 2 bag
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// File to write: .csv, .mat (v5), .h5, .parquet or .mcap (opens in PlotJuggler, Foxglove and Rerun)
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    mapping: Mapping,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    let failure = |e: signals::Error| Failure::in_file(&args.output, e);
    signals::check_suffix(&args.output).map_err(failure)?;
    files::check_writable(&args.output)?;
    let recording = reading::read(&args.input, &args.mapping)?;
    if let Some(remark) = recording.write(&args.output).map_err(failure)? {
        eprintln!("{}: {remark}", args.output.display());
    }
    println!(
        "{}: {} samples, {} signals",
        args.output.display(),
        recording.len(),
        recording.columns().len() + recording.extra.len()
    );
    Ok(Outcome::Done)
}
