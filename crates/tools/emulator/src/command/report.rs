//! `emulator report [ELF]`

use emulator::report::observe;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::process::ExitCode;

/// Options of `report`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Image to observe; without one, the firmware of this workspace is built
    #[arg(value_name = "ELF")]
    elf: Option<PathBuf>,
    /// Virtual time under full load, s
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// Write the figures as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Exit with code 1 if a bar is not met
    #[arg(long)]
    expect: bool,
}

/// Observes the firmware and prints the table.
///
/// # Errors
/// One line with the reason.
pub fn run(args: &Args) -> Result<ExitCode, String> {
    if let Some(path) = &args.json {
        // before a minute of work
        std::fs::File::create(path).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    let image = super::image(args.elf.as_deref())?;
    let bar = ProgressBar::new(1000);
    let style = ProgressStyle::with_template("  {msg} {bar:30.cyan/dim} {percent:>3} %  {elapsed}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message("the firmware under full load");
    let report = observe(&image, args.seconds, |share| bar.set_position((1000.0 * share) as u64));
    bar.finish_and_clear();
    let report = report.map_err(|e| e.to_string())?;
    println!("{report}");
    if let Some(path) = &args.json {
        let json = serde_json::to_string_pretty(&report).map_err(|e| e.to_string())?;
        std::fs::write(path, json + "\n").map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(if args.expect && !report.met { ExitCode::from(1) } else { ExitCode::SUCCESS })
}
