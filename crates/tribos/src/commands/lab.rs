//! `tribos lab [PORT|sim]`

use crate::failure::{Failure, Outcome, Result};
use crate::lab_tools::HostTools;
use crate::live;
use lab::{Lab, Options};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::channel;

/// Options of `lab`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Serial port of the device, or `sim` for a virtual one, whose handle the mouse holds
    #[arg(value_name = "PORT|sim", default_value = "sim")]
    port: String,
    /// Address to listen on; beyond loopback a token is needed to open the page
    #[arg(long, value_name = "IP", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    bind: IpAddr,
    /// Port of the page; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = 7700)]
    http_port: u16,
    /// Token that opens the page; drawn at random beyond loopback when not given
    #[arg(long, value_name = "TOKEN", value_parser = token)]
    token: Option<String>,
    /// Folder for recordings, experiments and reports
    #[arg(long, value_name = "DIR", default_value = "tribos-lab")]
    out: PathBuf,
    #[command(flatten)]
    live: live::Options,
    /// Open the page in the browser
    #[arg(long)]
    open: bool,
    /// Seed of the virtual device
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn token(text: &str) -> std::result::Result<String, String> {
    let fits = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_');
    if (16..=128).contains(&text.len()) && text.bytes().all(fits) {
        Ok(text.to_owned())
    } else {
        Err("16 to 128 of a-z, A-Z, 0-9, - and _ are accepted".into())
    }
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    if args.out.exists() && !args.out.is_dir() {
        return Err(Failure::in_file(&args.out, "is no folder; --out takes one"));
    }
    let beyond = !args.bind.is_loopback();
    let live = args.live.open()?;
    let tallies = live.tallies();
    let options = Options {
        address: SocketAddr::new(args.bind, args.http_port),
        token: args.token.clone().or_else(|| beyond.then(lab::new_token)),
        folder: args.out.clone(),
        live,
    };
    let tools = HostTools::new(&args.port, args.seed);
    // a port that is not there is told now, not on a page
    tools.check()?;
    let mut lab = Lab::start(options, Arc::new(tools)).map_err(|why| {
        Failure::new(why).help("another lab may be running: --http-port 0 takes a free port")
    })?;
    println!("the lab is open: {}", lab.url());
    println!("  device {}, files in {}, Ctrl-C ends it", args.port, args.out.display());
    if beyond {
        println!("  everybody on this network who has the token can drive the handle");
    }
    if args.open {
        open(&lab.url());
    }
    let (ended, end) = channel();
    // without a handler Ctrl-C ends the process at once; the device then lets go by itself
    let _ = ctrlc::set_handler(move || {
        let _ = ended.send(());
    });
    let _ = end.recv();
    lab.stop();
    for tally in tallies {
        println!("  {tally}");
    }
    println!("the lab is closed, force off");
    Ok(Outcome::Done)
}

/// Asks the desktop to show a page. Without a desktop the printed address remains.
fn open(url: &str) {
    let program = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    let quiet = std::process::Stdio::null;
    let started =
        std::process::Command::new(program).arg(url).stdout(quiet()).stderr(quiet()).stdin(quiet()).spawn();
    if started.is_err() {
        println!("  no `{program}` here: open the address yourself");
    }
}
