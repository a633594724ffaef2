//! `tribos preset list|show|push|pull`: presets between the library, a device, and files that people read, edit and
//! share.

use crate::failure::{Failure, Outcome, Result};
use crate::files;
use clap::Subcommand;
use client::{Session, Settled};
use identify::Model;
use procedures::library::{self, PRESETS};
use report::Table;
use std::path::{Path, PathBuf};

/// Options of `preset`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// The presets that come with tribos
    List,
    /// Print one of them as a file: `tribos preset show rubber-1 > mine.toml`
    Show(Show),
    /// Give a device the preset of a file, and save it there under the file's name
    Push(Push),
    /// Write a device's preset to a file
    Pull(Pull),
}

#[derive(Debug, clap::Args)]
struct Show {
    /// Name, as listed by `preset list`
    #[arg(value_name = "NAME")]
    name: String,
}

#[derive(Debug, clap::Args)]
struct Push {
    /// Serial port of the device, or `sim` for a virtual one
    #[arg(value_name = "PORT|sim")]
    port: String,
    /// Preset: a name from `preset list`, or a file written by hand, by `preset pull`, `identify --out` or
    /// `diagnose --out`
    #[arg(value_name = "FILE.toml|NAME")]
    file: PathBuf,
    /// Name on the device; by default that in the file
    #[arg(long)]
    name: Option<String>,
}

#[derive(Debug, clap::Args)]
struct Pull {
    /// Serial port of the device, or `sim` for a virtual one
    #[arg(value_name = "PORT|sim")]
    port: String,
    /// File to write
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// Preset on the device; by default the active one with its changes
    #[arg(long)]
    name: Option<String>,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    match &args.action {
        Action::List => list(),
        Action::Show(args) => show(args),
        Action::Push(args) => push(args),
        Action::Pull(args) => pull(args),
    }
}

/// A line of a listing: `  k_vc 8000 N/m`.
struct Entry {
    name: String,
    value: String,
    unit: Option<String>,
}

/// Every parameter of a listing.
fn entries(listing: &[String]) -> impl Iterator<Item = Entry> {
    listing.iter().filter(|line| line.starts_with("  ")).filter_map(|line| {
        let mut words = line.split_whitespace().map(str::to_owned);
        Some(Entry { name: words.next()?, value: words.next()?, unit: words.next() })
    })
}

/// Name and value of every parameter of a listing.
fn values(listing: &[String]) -> Vec<(String, String)> {
    entries(listing).map(|entry| (entry.name, entry.value)).collect()
}

/// A name as the device takes it, from a file's.
fn name_of(file: &Path) -> String {
    file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

fn list() -> Result<Outcome> {
    let mut table = Table::new(&["preset", "what it is"]);
    for preset in PRESETS {
        table.row([preset.name.to_owned(), preset.about()]);
    }
    files::write(Path::new("-"), table.render().as_bytes())?;
    Ok(Outcome::Done)
}

fn show(args: &Show) -> Result<Outcome> {
    let preset = library::find(&args.name).ok_or_else(|| {
        Failure::new(format!("no preset `{}` in the library", args.name))
            .help("`tribos preset list` has the names")
    })?;
    files::write(Path::new("-"), preset.text.as_bytes())?;
    Ok(Outcome::Done)
}

fn push(args: &Push) -> Result<Outcome> {
    let model = library::read(&args.file)?;
    let name = args.name.clone().unwrap_or_else(|| name_of(&args.file));
    let mut session = Session::open(&args.port, 1)?;
    let before = values(&session.exchange("get")?);
    // effects that the file does not have
    let wanted = model.preset_lines();
    let effect = |name: &str| name.split_once('.').map(|(effect, _)| effect.to_owned());
    let kept: Vec<String> = wanted.iter().filter_map(|(name, _)| effect(name)).collect();
    let mut gone: Vec<String> = before.iter().filter_map(|(name, _)| effect(name)).collect();
    gone.dedup();
    for id in gone.iter().filter(|id| !kept.contains(id)) {
        session.command(&format!("set {id} off"))?;
    }
    let Settled { refused, warning } = session.set_all(&wanted)?;
    warning.iter().for_each(|warning| println!("  warning: {warning}"));
    let saved =
        if refused.is_empty() { session.command(&format!("preset save {name}")) } else { Ok(String::new()) };
    if !refused.is_empty() || saved.is_err() {
        // as it was
        for id in &kept {
            session.command(&format!("set {id} off"))?;
        }
        session.set_all(&before)?;
    }
    if let Some(first) = refused.first() {
        return Err(Failure::in_file(&args.file, format!("the device refuses it: {first}"))
            .help("nothing was changed; `tribos design` finds what the device would take"));
    }
    let answer = saved?;
    println!("{}: {}", args.file.display(), answer.trim_start_matches("ok").trim());
    Ok(Outcome::Done)
}

fn pull(args: &Pull) -> Result<Outcome> {
    files::check_writable(&args.file)?;
    let mut session = Session::open(&args.port, 1)?;
    let (what, listing) = match &args.name {
        Some(name) => {
            let listing = session.exchange(&format!("preset show {name}"))?;
            if let Some((_, why)) = listing.iter().find_map(|line| link::reply::refusal(line)) {
                return Err(Failure::new(format!("{}: preset {name}: {}", args.port, why.trim())));
            }
            (name.clone(), listing)
        }
        None => (name_of(&args.file), session.exchange("get")?),
    };
    let mut text = format!(
        "# preset {what}, from {}; every line is `set NAME VALUE` on the device\n[preset]\n",
        args.port
    );
    for Entry { name, value, unit } in entries(&listing) {
        let unit = unit.map_or_else(String::new, |unit| format!(" # {unit}"));
        let value = if value.parse::<f64>().is_ok() { value } else { format!("\"{value}\"") };
        text.push_str(&format!("{name} = {value}{unit}\n"));
    }
    // what is written is what is read again
    Model::from_toml(&args.file.display().to_string(), &text).map_err(Failure::new)?;
    files::write(&args.file, text.as_bytes())?;
    println!("{}: {what}", args.file.display());
    Ok(Outcome::Done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_pushed_and_pulled_is_the_same() {
        let mut session = Session::open("sim", 1).expect("a virtual device");
        let before = values(&session.exchange("get").expect("a listing"));
        // heavier and stiffer: neither order of the two is accepted for every pair
        let wanted: Vec<(String, String)> = [
            ("k_vc", "20000"),
            ("mass", "0.5"),
            ("f_static", "3.5"),
            ("f_dynamic", "3"),
            ("dv", "0.02"),
            ("stribeck.force_p", "0.2"),
        ]
        .map(|(name, value)| (name.to_owned(), value.to_owned()))
        .to_vec();
        assert_eq!(session.set_all(&wanted).expect("a line"), Settled::default());
        let after = values(&session.exchange("get").expect("a listing"));
        assert!(after.contains(&("k_vc".into(), "20000".into())), "{after:?}");
        session.command("set stribeck off").expect("taken");
        assert_eq!(session.set_all(&before).expect("a line").refused, Vec::<String>::new());
        assert_eq!(values(&session.exchange("get").expect("a listing")), before);
    }

    #[test]
    fn what_is_refused_for_good_is_told() {
        let mut session = Session::open("sim", 1).expect("a virtual device");
        let Settled { refused, .. } = session.set_all(&[("k_vc".into(), "1e9".into())]).expect("a line");
        assert_eq!(refused.len(), 1);
        assert!(refused[0].contains("k_vc"), "{refused:?}");
    }
}
