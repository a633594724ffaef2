//! `tribos demo`: the whole story on the virtual device.

use super::{diagnose as diagnosing, identify as identifying};
use crate::failure::{Failure, Outcome, Result};
use crate::options::Mapping;
use crate::progress::Progress;
use crate::terminal::record;
use crate::{files, reading};
use client::{Event, Move, Plan, Session, Settled, Virtual};
use diagnose::{Options, diagnose};
use friction::effects::{Effect, EffectKind};
use haptics::Wave;
use identify::{KarnoppOptions, Model, Preprocess, identify_karnopp, prepare};
use plant::materials::BRASS;
use procedures::conceal::{concealable, concealed};
use report::number::number;
use std::path::{Path, PathBuf};
use tribos_firmware::board::simulated::Holder;

/// Options of `demo`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the results; by default a new one in the working directory
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Effect to conceal in the rig: an effect of the catalogue, `random` or `none`
    #[arg(long, value_name = "EFFECT", default_value = "random")]
    conceal: String,
    /// Seed of all noise, and of the random choice
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Motion of the recording: five harmonics, so that position, velocity and acceleration come apart.
const MOTION: Move = Move { wave: Wave::Multisine, amplitude: 0.01, frequency: 0.8, seconds: Some(20.0) };

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    let effect = choose(&args.conceal, 1.0, args.seed)?;
    let out = args.out.clone().unwrap_or_else(|| fresh_folder("tribos-demo"));
    std::fs::create_dir_all(&out)
        .map_err(|e| Failure::in_file(&out, format!("cannot be made a folder: {}", files::reason(&e))))?;
    let file = |name: &str| out.join(name);
    files::check_writable(&file("recording.csv"))?;

    println!("Everything below happens on a virtual device; its files go to {}.", out.display());
    println!("\n1  A handle that feels like brass");
    println!(
        "   A motor makes a free handle resist like a block sliding on brass. It receives this over its"
    );
    println!("   serial line, and a simulated hand tries it.\n");
    feel("brass", args.seed)?;

    println!("\n2  A real block on brass, driven and recorded");
    println!(
        "   Now a block really slides. Something may have been concealed in the rig: you are told at the end.\n"
    );
    let effects: Vec<Effect<f64>> = effect.into_iter().collect();
    let recording = slide(args.seed, &effects, &file("recording.csv"))?;

    println!("\n3  Its friction, identified");
    println!("   The textbook model: a mass, Coulomb and viscous friction, each direction its own.\n");
    let signals = prepare(&recording, &Preprocess::default()).map_err(Failure::new)?;
    let identified = identify_karnopp(&signals, &KarnoppOptions::default()).map_err(Failure::new)?;
    print!("{}", identifying::describe("recording.csv", &identified, None));
    let text = identified.to_json().map_err(Failure::new)?;
    files::write(&file("identification.json"), text.as_bytes())?;

    println!("\n4  What that model leaves out");
    println!(
        "   Every effect of a catalogue competes to explain what is left, judged on data it was not fitted to.\n"
    );
    let found = {
        let bar = Progress::new("diagnosing");
        let progress = |share: f32, what: &str| bar.set(share, what);
        diagnose(std::slice::from_ref(&recording), &[], &Options::default(), &progress)
            .map_err(Failure::new)?
    };
    print!("{}", diagnosing::outline("recording.csv", &found));
    files::write_json(&file("diagnosis.json"), &found)?;
    files::write(&file("report.html"), report::diagnosis(&found, "recording.csv").as_bytes())?;

    println!("\n5  The envelope is opened\n");
    println!("  concealed in the rig: {}", effect.map_or("nothing", |e| e.kind.id()));
    let first = found.missing.first().map(|m| m.effect.as_str());
    println!("  named first:          {}", first.unwrap_or("nothing"));
    let rivals = found.missing.first().map(|m| m.indistinguishable_from.join(", ")).unwrap_or_default();
    if !rivals.is_empty() {
        println!("  explains it as well:  {rivals}");
    }

    if let Some(model) = &found.model {
        println!("\n6  What was found, felt");
        println!("   The model that was found is a preset: the handle renders it the same minute.\n");
        let model = Model { name: "found".into(), ..model.clone() };
        files::write(&file("model.toml"), model.to_toml().as_bytes())?;
        push(&model, args.seed)?;
    }
    println!("\nThe report: {}", file("report.html").display());
    println!(
        "Beside it: recording.csv, identification.json, diagnosis.json{}.",
        if found.model.is_some() { ", model.toml" } else { "" }
    );
    println!("Your own device: cargo tribos record PORT --move \"{MOTION}\" --out mine.csv");
    println!("                 cargo tribos diagnose mine.csv --report mine.html");
    Ok(Outcome::Done)
}

/// `name`, or the first `name-N` that does not exist: nothing earlier is overwritten.
pub(crate) fn fresh_folder(name: &str) -> PathBuf {
    let first = PathBuf::from(name);
    if !first.exists() {
        return first;
    }
    (2_u32..).map(|n| PathBuf::from(format!("{name}-{n}"))).find(|dir| !dir.exists()).unwrap_or(first)
}

/// The effect asked for, at a multiple of its usual size.
pub(crate) fn choose(name: &str, size: f64, seed: u64) -> Result<Option<Effect<f64>>> {
    let kinds = concealable();
    let kind = match name {
        "none" => return Ok(None),
        // neighbouring seeds take neighbouring effects, so that a few runs show several
        "random" => kinds.get((seed.wrapping_mul(7) % kinds.len().max(1) as u64) as usize).copied(),
        name => kinds.iter().copied().find(|kind| kind.id() == name),
    };
    let kind: EffectKind = kind.ok_or_else(|| {
        let ids: Vec<&str> = kinds.iter().map(|kind| kind.id()).collect();
        Failure::new(format!("--conceal: `{name}` cannot be concealed"))
            .help(format!("accepted are none, random, {}", ids.join(", ")))
    })?;
    Ok(concealed(kind, size))
}

/// A preset over the serial line, under a simulated hand: force against velocity in a few rows.
fn feel(preset: &str, seed: u64) -> Result<()> {
    let mut device = Virtual::new(seed)?;
    device.device().hold(Holder::to_and_fro(0.008, 0.5));
    let mut session = Session::over("sim", Box::new(device));
    for line in ["version".to_owned(), format!("preset use {preset}"), "render on".into(), "stream on".into()]
    {
        said(&line, &session.command(&line)?);
    }
    let mut samples = Vec::new();
    while samples.len() < 4_000 {
        for event in session.poll()? {
            if let Event::Sample(sample) = event {
                samples.push(sample);
            }
        }
    }
    for line in ["stream off", "render off"] {
        said(line, &session.command(line)?);
    }
    println!("\n  a simulated hand moves the handle 8 mm to and fro; the force it meets:");
    let mean = |low: f64, high: f64| {
        let forces: Vec<f64> =
            samples.iter().filter(|p| p.velocity > low && p.velocity < high).map(|p| -p.command).collect();
        forces.iter().sum::<f64>() / forces.len().max(1) as f64
    };
    for (what, low, high) in
        [("forward, 10 to 25 mm/s", 0.010, 0.025), ("back, 10 to 25 mm/s", -0.025, -0.010)]
    {
        println!("    {what:<24} {:+.2} N", mean(low, high));
    }
    Ok(())
}

/// Drives a block on brass, and on a concealed effect, and records it over the serial line.
fn slide(seed: u64, effects: &[Effect<f64>], path: &Path) -> Result<signals::Recording> {
    let mut device = Virtual::new(seed)?;
    device.device().set_block(BRASS.mass, BRASS.law, effects).map_err(Failure::new)?;
    let mut session = Session::over("sim", Box::new(device));
    let plan = Plan { motion: Some(MOTION), seconds: MOTION.seconds.unwrap_or(20.0), notes: Vec::new() };
    let recorded = record(&mut session, &plan, path)?;
    println!(
        "  move {MOTION}: {} samples at 1 kHz through the rig's encoder, load cell and accelerometer, {} lost",
        recorded.samples, recorded.lost
    );
    reading::read(path, &Mapping::default())
}

/// Sends a model to the device as a preset and renders it.
fn push(model: &Model, seed: u64) -> Result<()> {
    let mut session = Session::over("sim", Box::new(Virtual::new(seed)?));
    let wanted = model.preset_lines();
    let Settled { refused, warning } = session.set_all(&wanted)?;
    println!("  {} of {} parameters accepted", wanted.len() - refused.len(), wanted.len());
    refused.iter().chain(&warning).for_each(|line| println!("  {line}"));
    let line = "preset save found";
    said(line, &session.command(line)?);
    said("render on", &session.command("render on")?);
    println!("  The handle now feels like the block: {} kg, with the friction found.", number(model.mass, 4));
    Ok(())
}

fn said(line: &str, answer: &str) {
    println!("  > {line}\n  {answer}");
}
