//! `tribos convert IN OUT`

use crate::failure::{Failure, Outcome, Result};
use crate::options::Mapping;
use crate::{files, mat_file, mcap_file, reading};
use std::path::PathBuf;

/// Options of `convert`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Recording to read: .csv, .mat (v5) or .json
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// File to write: .csv, .mat (v5) or .mcap (opens in PlotJuggler, Foxglove and Rerun)
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    mapping: Mapping,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    let extension = args.output.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    if !matches!(extension.as_str(), "csv" | "mat" | "mcap") {
        return Err(Failure::in_file(&args.output, format!("cannot write `.{extension}`"))
            .help("a name ending in .csv, .mat or .mcap is accepted"));
    }
    files::check_writable(&args.output)?;
    let recording = reading::read(&args.input, &args.mapping)?;
    match extension.as_str() {
        "mcap" => mcap_file::write(&args.output, &recording)?,
        "mat" => mat_file::write(&args.output, &recording)?,
        _ => reading::write_csv(&args.output, &recording)?,
    }
    println!(
        "{}: {} samples, {} signals",
        args.output.display(),
        recording.len(),
        1 + crate::columns::columns(&recording).len()
    );
    Ok(Outcome::Done)
}
