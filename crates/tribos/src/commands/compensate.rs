//! `tribos compensate --model model.toml PORT|sim|FILE`

use super::demo;
use crate::failure::{Failure, Outcome, Result};
use crate::options::{self, Mapping};
use crate::terminal::{Terminal, enter, reference};
use crate::{files, reading};
use client::Session;
use friction::effects::EffectKind;
use friction::{Dimension, Geometry};
use haptics::Device;
use identify::Model;
use procedures::compensated::{self, FeedForward, Felt, Hand, Measured};
use report::{Compensated, Table};
use signals::{ReadOptions, Recording};
use std::path::{Path, PathBuf};

/// Friction, N, and cogging, N and m, of the rig behind `sim`: the friction of [thesis, table 3-1].
const RIG: [&str; 2] = ["sim friction 1.04 0.69", "sim cogging 0.2 0.004"];
/// How the simulated hand moves the handle.
const SIMULATED_HAND: &str = "sim hand sine 0.008 0.5";

/// Options of `compensate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Serial port of the device, `sim` for the virtual device, or a recording: what the feed-forward would leave of it
    #[arg(value_name = "PORT|sim|FILE")]
    target: String,
    /// Model of the device itself: identified with its command as the force. Without one a device learns it first: its free
    /// handle swings, and sweeps slowly; hands off
    #[arg(long, value_name = "model.toml")]
    model: Option<PathBuf>,
    /// Share of what was found that is fed forward, up to 0.9
    #[arg(long, default_value = "0.9", value_parser = options::factor, allow_hyphen_values = true)]
    share: f64,
    /// Length of a recording by hand, s
    #[arg(long, default_value = "12", value_parser = options::seconds, allow_hyphen_values = true)]
    seconds: f64,
    /// Folder for the recordings before, after and at rest, the model and the report; by default a new one in the working
    /// directory
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Let a device that does not know the middle of its stroke search both stops, without asking; hands off
    #[arg(long)]
    yes: bool,
    /// `sim` only: seed of all noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// FILE only: its position has the zero of the model's recordings, so that the phase of cogging holds
    #[arg(long)]
    absolute: bool,
    #[command(flatten)]
    mapping: Mapping,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    let path = Path::new(&args.target);
    let model = match &args.model {
        Some(file) => Some(Model::read(file).map_err(|e| Failure::in_file(file, e))?),
        None => None,
    };
    if path.is_file() || (path.extension().is_some() && !path.starts_with("/dev")) {
        let Some(model) = model else {
            return Err(Failure::new(format!(
                "{}: a recording needs --model; a device learns its own",
                path.display()
            )));
        };
        return predict(args, path, &model);
    }
    on_device(args, model)
}

/// Says what a feed-forward would leave of a recording. Nothing moves.
fn predict(args: &Args, path: &Path, model: &Model) -> Result<Outcome> {
    let recording = reading::read(path, &args.mapping)?;
    let device = Device { geometry: model.geometry, ..Device::default() };
    let feed = FeedForward::of(model, args.share, &device)?;
    let left = compensated::predict(model, &feed, &recording, args.absolute)?;
    let n = Dimension::FORCE.unit(model.geometry);
    println!("{}", fed(&feed));
    println!("{}", stability(&feed).join("\n"));
    println!(
        "{}: friction, damping and cogging of {:.3} {n} rms become {:.3} {n}, {:.0} %; the model leaves {:.3} {n}; {} samples",
        path.display(),
        left.before,
        left.after,
        100.0 * left.after / left.before,
        left.unexplained,
        left.samples
    );
    Ok(Outcome::Done)
}

fn on_device(args: &Args, model: Option<Model>) -> Result<Outcome> {
    let simulated = args.target == "sim";
    let mut session = Session::open(&args.target, args.seed)?;
    reference(&mut session, args.yes)?;
    if simulated {
        for line in RIG {
            println!("{}: {}", args.target, session.command(line)?.trim_start_matches("ok "));
        }
    }
    let device = compensated::device_of(&mut session)?;
    // what the device would refuse, before a file is made
    let checked = match &model {
        Some(model) => Some(FeedForward::of(model, args.share, &device)?),
        None => None,
    };
    let out = args.out.clone().unwrap_or_else(|| demo::fresh_folder("tribos-compensation"));
    std::fs::create_dir_all(&out)
        .map_err(|e| Failure::in_file(&out, format!("cannot be made a folder: {}", files::reason(&e))))?;
    let (model, feed) = match (model, checked) {
        (Some(model), Some(feed)) => (model, feed),
        _ => {
            if !simulated {
                enter("hands off the handle: it swings and sweeps for 40 s")?;
            }
            let model = compensated::learn(&mut session, &device, &out, &Terminal)?;
            let feed = FeedForward::of(&model, args.share, &device)?;
            (model, feed)
        }
    };
    files::write(&out.join("model.toml"), model.to_toml().as_bytes())?;
    println!("{}", fed(&feed));
    let seconds = args.seconds;
    let mut hand = |session: &mut Session, hand: Hand| {
        if simulated {
            session.command(if hand == Hand::Moves { SIMULATED_HAND } else { "sim hand off" })?;
        } else {
            // at a pipe nobody is asked
            let _ = enter(&match hand {
                Hand::Moves => {
                    format!("take the handle and move it to and fro, smoothly, for twice {seconds} s")
                }
                Hand::Off => "let go of the handle".to_owned(),
            });
        }
        Ok(())
    };
    let measured = compensated::measure(&mut session, &feed, &out, args.seconds, &Terminal, &mut hand)?;
    let rows = rows(&measured, device.geometry);
    let mut table = Table::new(&["the hand feels", ">before", ">after", ""]);
    for row in &rows {
        table.row(row.iter().map(String::as_str));
    }
    print!("{}", table.render());
    let mut notes = vec![error_left(&measured, device.geometry), at_rest(&measured)];
    notes.extend(stability(&feed));
    println!("{}", notes.join("\n"));
    let report = Compensated {
        name: args.target.clone(),
        headline: error_left(&measured, device.geometry),
        rows: rows.to_vec(),
        notes,
        units: [Dimension::VELOCITY, Dimension::FORCE].map(|d| d.unit(device.geometry).to_string()),
        felt: [points(&out.join("before.csv"))?, points(&out.join("after.csv"))?],
    };
    files::write(&out.join("report.html"), report::compensation(&report).map_err(Failure::new)?.as_bytes())?;
    println!("files: {}", out.display());
    Ok(if measured.rests && measured.after.mean() < measured.before.mean() {
        println!("the feed-forward stays on until the device restarts or `compensate off`");
        Outcome::Done
    } else {
        Outcome::ExpectedFindingAbsent
    })
}

/// What is fed forward, in one line.
fn fed(feed: &FeedForward) -> String {
    let mut text = format!("feeds forward: {}", feed.settings.on(feed.geometry));
    for left_out in &feed.left_out {
        text += &format!("\n  not fed forward: {left_out}");
    }
    text
}

/// The verdict of stability, in two lines.
fn stability(feed: &FeedForward) -> Vec<String> {
    let unit = Dimension::DAMPING.unit(feed.geometry);
    let certain = feed
        .certain_from
        .map_or(String::new(), |share| format!(" ({:.1} % with two standard errors)", 100.0 * share));
    let [left, needed] = feed.damping;
    vec![
        format!(
            "stability: passive while the friction is at least {:.1} % of what was found{certain}; less drives a limit cycle",
            100.0 * feed.passive_from
        ),
        format!(
            "stability: the sampled effects need {needed:.3} of the {left:.3} {unit} of damping that are left"
        ),
    ]
}

fn rows(measured: &Measured, geometry: Geometry) -> [[String; 4]; 5] {
    let unit = |dimension: Dimension| dimension.unit(geometry).to_string();
    let row = |name: &str, value: &dyn Fn(&Felt) -> String, dimension| {
        [name.to_owned(), value(&measured.before), value(&measured.after), unit(dimension)]
    };
    let level =
        |k: usize| move |felt: &Felt| format!("{:.3} ± {:.3}", felt.friction[k], felt.friction_std[k]);
    [
        row("friction, forward", &level(0), Dimension::FORCE),
        row("friction, back", &level(1), Dimension::FORCE),
        row("break-away", &|felt| format!("{:.3}", felt.break_away), Dimension::FORCE),
        row(EffectKind::Cogging.id(), &|felt| format!("{:.3}", felt.cogging), Dimension::FORCE),
        row("damping", &|felt| format!("{:.2}", felt.damping), Dimension::DAMPING),
    ]
}

fn error_left(measured: &Measured, geometry: Geometry) -> String {
    let (before, after) = (measured.before.mean(), measured.after.mean());
    let unit = Dimension::FORCE.unit(geometry);
    format!(
        "friction of {before:.3} {unit} is felt as {after:.3} {unit}: {:.0} % is left",
        100.0 * after / before
    )
}

fn at_rest(measured: &Measured) -> String {
    let verdict =
        if measured.rests { "no limit cycle" } else { "a limit cycle: switched off; --share asks for less" };
    format!("released, the handle moves by {:.1} counts in two seconds: {verdict}", measured.rest_counts)
}

/// Velocity and push of the hand.
fn points(path: &Path) -> Result<Vec<(f64, f64)>> {
    let recording = Recording::read(path, &ReadOptions::default()).map_err(|e| Failure::in_file(path, e))?;
    let velocity = recording.velocity.unwrap_or_default();
    Ok(velocity.into_iter().zip(recording.force.iter().map(|force| -force)).collect())
}
