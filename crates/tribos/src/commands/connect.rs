//! `tribos connect PORT | sim`

use crate::console;
use crate::failure::{Outcome, Result};
use crate::live;
use client::Session;
use std::io::IsTerminal;

/// Options of `connect`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Serial port of the device, or `sim` for the virtual device
    #[arg(value_name = "PORT|sim")]
    port: String,
    /// Seed of the virtual device
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    live: live::Options,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    let mut live = args.live.open()?;
    let mut session = Session::open(&args.port, args.seed)?;
    let ended = if std::io::stdin().is_terminal() && std::io::stdout().is_terminal() {
        if args.port == "sim" {
            // a plot of nothing tells nothing: a hand moves the virtual handle, and it resists
            session.command("sim hand sine 0.008 0.5")?;
            session.command("render on")?;
        }
        console::screen(&mut session, &args.port, &mut live)
    } else {
        console::lines(&mut session, &mut live)
    };
    for tally in live.tallies() {
        eprintln!("{tally}");
    }
    ended.map(|()| Outcome::Done)
}
