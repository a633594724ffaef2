//! `tribos investigate PORT|sim`

use super::demo;
use crate::failure::{Failure, Outcome, Result};
use crate::files;
use crate::options;
use crate::terminal::{Terminal, reference};
use client::{Move, Session, Virtual};
use diagnose::Limits;
use friction::effects::Effect;
use haptics::{Device, Wave};
use identify::Model;
use plant::materials::BRASS;
use procedures::investigate::{Budget, Loop, beliefs};
use std::path::{Path, PathBuf};

/// Options of `investigate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Serial port of the device, or `sim` for the virtual device
    #[arg(value_name = "PORT|sim")]
    port: String,
    /// Folder for recordings, model, diagnosis and report; by default a new one in the working directory
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The first move
    #[arg(long, value_name = "WAVE AMP FREQ [SECONDS]", default_value_t = FIRST)]
    first: Move,
    /// Longest total motion, s
    #[arg(long, value_name = "SECONDS", default_value = "120", value_parser = options::seconds, allow_hyphen_values = true)]
    budget: f64,
    /// Largest number of rounds
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..=100))]
    rounds: u16,
    /// Let a device that does not know the middle of its stroke search both stops, without asking; hands off
    #[arg(long)]
    yes: bool,
    /// `sim` only: effect to conceal in the rig: an effect of the catalogue, `random` or `none`
    #[arg(long, value_name = "EFFECT")]
    conceal: Option<String>,
    /// `sim` only: strength of the effect, relative to that in `demo`
    #[arg(long, value_name = "TIMES", default_value = "1", value_parser = options::factor, allow_hyphen_values = true)]
    size: f64,
    /// `sim` only: seed of all noise, and of the random choice
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write rounds and diagnosis as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Exit with 1 unless this effect is named and nothing else explains the recordings as well
    #[arg(long, value_name = "EFFECT")]
    expect: Option<String>,
}

/// The excitation of [thesis, ch. 3.5]: simple, and blind to much.
const FIRST: Move = Move { wave: Wave::Sine, amplitude: 0.01, frequency: 2.0, seconds: Some(12.0) };

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    if args.conceal.is_some() && args.port != "sim" {
        return Err(Failure::new("--conceal: a real device hides what it hides; accepted with `sim`"));
    }
    if let Some(effect) = &args.expect {
        procedures::diagnosed::check_finding(effect)?;
    }
    if let Some(path) = &args.json {
        files::check_writable(path)?;
    }
    let effect = args.conceal.as_deref().map_or(Ok(None), |name| demo::choose(name, args.size, args.seed))?;
    let mut session = open(&args.port, args.seed, effect.as_ref())?;
    reference(&mut session, args.yes)?;
    let notes = vec![("device".to_owned(), session.command("version")?.trim_start_matches("ok ").to_owned())];
    let out = args.out.clone().unwrap_or_else(|| demo::fresh_folder("tribos-investigation"));
    std::fs::create_dir_all(&out)
        .map_err(|e| Failure::in_file(&out, format!("cannot be made a folder: {}", files::reason(&e))))?;

    // standard output belongs to the JSON where it is asked for there
    let quiet = args.json.as_deref() == Some(Path::new("-"));
    let mut say = |line: &str| {
        if !quiet {
            println!("{line}");
        }
    };
    let budget = Budget { seconds: args.budget, rounds: usize::from(args.rounds) };
    say(&format!(
        "{}: at most {} rounds, {} s of motion; files go to {}",
        args.port,
        budget.rounds,
        budget.seconds,
        out.display()
    ));
    let limits = Limits::of_device(&Device::default());
    let done = Loop::new(&mut session, &out, limits, notes, &Terminal).run(args.first, budget, &mut say)?;

    let file = |name: &str| out.join(name);
    let found = &done.diagnosis;
    let name = done.rounds.iter().map(|r| r.recording.as_str()).collect::<Vec<_>>().join(", ");
    files::write_json(&file("diagnosis.json"), found)?;
    files::write(&file("report.html"), report::diagnosis(found, &name).as_bytes())?;
    if let Some(model) = &found.model {
        let model = Model { name: "investigated".into(), ..model.clone() };
        files::write(&file("model.toml"), model.to_toml().as_bytes())?;
    }
    files::write_json(args.json.as_deref().unwrap_or(&file("investigation.json")), &done)?;

    say(&format!("\nafter {} rounds: {}", done.rounds.len(), done.ended.says()));
    for line in beliefs(found) {
        say(&format!("  {line}"));
    }
    for b in &found.blind_to {
        say(&format!("  still blind to {}: {}", b.effect, b.experiment));
    }
    if args.conceal.is_some() {
        say(&format!("  concealed in the rig: {}", effect.map_or("nothing", |e| e.kind.id())));
    }
    say(&format!("report: {}", file("report.html").display()));
    Ok(match &args.expect {
        Some(expected) if !is_settled(found, expected) => Outcome::ExpectedFindingAbsent,
        _ => Outcome::Done,
    })
}

/// The effect is named, and no other is left that a motion could tell it from.
fn is_settled(found: &diagnose::Diagnosis, effect: &str) -> bool {
    super::diagnose::is_there(found, effect)
        && !found.experiments.iter().any(|e| e.effect == effect && e.rival.is_some())
}

/// The line to the device, with the block mounted on the virtual one.
fn open(port: &str, seed: u64, effect: Option<&Effect<f64>>) -> Result<Session> {
    if port != "sim" {
        return Ok(Session::open(port, seed)?);
    }
    let mut device = Virtual::new(seed)?;
    let concealed: Vec<Effect<f64>> = effect.copied().into_iter().collect();
    device.device().set_block(BRASS.mass, BRASS.law, &concealed).map_err(Failure::new)?;
    Ok(Session::over(port, Box::new(device)))
}
