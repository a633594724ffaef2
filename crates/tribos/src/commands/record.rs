//! `tribos record PORT|sim`

use crate::failure::{Failure, Outcome, Result};
use crate::options;
use crate::terminal::{record, reference};
use client::{Move, Plan, Session};
use std::path::PathBuf;

/// Options of `record`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Serial port of the device, or `sim` for the virtual device
    #[arg(value_name = "PORT|sim")]
    port: String,
    /// Recording to write, CSV
    #[arg(long, value_name = "rec.csv")]
    out: PathBuf,
    /// Length of the recording, s
    #[arg(long, default_value = "10", value_parser = options::seconds, allow_hyphen_values = true)]
    seconds: f64,
    /// Preset to render while somebody moves the handle
    #[arg(long, value_name = "NAME", conflicts_with = "motion")]
    preset: Option<String>,
    /// Motion to drive the handle with, e.g. "sine 0.01 2" (m, Hz)
    #[arg(long = "move", value_name = "WAVE AMP FREQ [SECONDS]")]
    motion: Option<Move>,
    /// Let a device that does not know the middle of its stroke search both stops, without asking; hands off
    #[arg(long)]
    yes: bool,
    /// `sim` only: what the real block slides on: none, brass, teflon or rubber
    #[arg(long, value_name = "MATERIAL")]
    block: Option<String>,
    /// `sim` only: seed of all noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    let simulated = args.port == "sim";
    if args.block.is_some() && !simulated {
        return Err(Failure::new(
            "--block: a real device has the block that is mounted on it; accepted with `sim`",
        ));
    }
    crate::files::check_writable(&args.out)?;
    let mut session = Session::open(&args.port, args.seed)?;
    if args.motion.is_some() || args.preset.is_some() {
        reference(&mut session, args.yes)?;
    }
    let mut notes =
        vec![("device".to_owned(), session.command("version")?.trim_start_matches("ok ").to_owned())];
    if simulated {
        // the rendered block is felt best without a real one
        let block = args.block.as_deref().unwrap_or(if args.preset.is_some() { "none" } else { "rubber" });
        let told = session.command(&format!("sim block {block}"))?;
        notes.push(("block".into(), told.trim_start_matches("ok ").to_owned()));
        if args.motion.is_none() {
            session.command("sim hand sine 0.008 1")?;
        }
    }
    if let Some(preset) = &args.preset {
        session.command(&format!("preset use {preset}"))?;
        session.command("render on")?;
    }
    let seconds = args.motion.and_then(|motion| motion.seconds).unwrap_or(args.seconds);
    let plan = Plan { motion: args.motion, seconds, notes };
    if !simulated && plan.motion.is_none() {
        eprintln!("recording {seconds} s: move the handle by hand");
    }
    let recorded = record(&mut session, &plan, &args.out)?;
    if args.preset.is_some() {
        session.command("render off")?;
    }
    let early = if recorded.interrupted { ", ended early" } else { "" };
    println!(
        "{}: {} samples, {:.3} s, {} lost{early}",
        args.out.display(),
        recorded.samples,
        recorded.seconds,
        recorded.lost
    );
    Ok(Outcome::Done)
}
