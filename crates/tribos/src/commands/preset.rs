//! `tribos preset push|pull PORT FILE`: presets between a device and files that people read, edit and share.

use crate::failure::{Failure, Outcome, Result};
use crate::files;
use crate::session::Session;
use clap::Subcommand;
use identify::Model;
use std::path::{Path, PathBuf};

/// Options of `preset`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Give a device the preset of a file, and save it there under the file's name
    Push(Push),
    /// Write a device's preset to a file
    Pull(Pull),
}

#[derive(Debug, clap::Args)]
struct Push {
    /// Serial port of the device, or `sim` for a virtual one
    #[arg(value_name = "PORT|sim")]
    port: String,
    /// Preset: a file written by hand, by `preset pull`, `identify --out` or `diagnose --out`
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// Name on the device; the file's when not given
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
    /// Preset on the device; what is active, changes included, when not given
    #[arg(long)]
    name: Option<String>,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    match &args.action {
        Action::Push(args) => push(args),
        Action::Pull(args) => pull(args),
    }
}

/// Name and value of every line of a listing: `  k_vc 8000 N/m`.
fn values(listing: &[String]) -> Vec<(String, String)> {
    listing
        .iter()
        .filter(|line| line.starts_with("  "))
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            Some((words.next()?.to_owned(), words.next()?.to_owned()))
        })
        .collect()
}

/// Sets what is not as wanted. Parameters depend on each other (a heavier block first, then a stiffer coupling), so
/// what is refused is tried again after the others; gives what is refused for good.
fn settle(session: &mut Session, wanted: &[(String, String)]) -> Result<Vec<String>> {
    let mut left: Vec<&(String, String)> = wanted.iter().collect();
    loop {
        let before = left.len();
        let mut refusals = Vec::new();
        let mut again = Vec::new();
        for line in left {
            let answer = session.exchange(&format!("set {} {}", line.0, line.1))?;
            match answer.iter().find_map(|text| link::reply::refusal(text)) {
                Some((_, why)) => {
                    refusals.push(format!("set {} {}: {}", line.0, line.1, why.trim()));
                    again.push(line);
                }
                None => {
                    if let Some(warning) = answer.iter().find(|text| text.starts_with("ok warn")) {
                        println!("  {warning}");
                    }
                }
            }
        }
        if again.is_empty() || again.len() == before {
            return Ok(refusals);
        }
        left = again;
    }
}

/// A name as the device takes it, from a file's.
fn name_of(file: &Path) -> String {
    file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

fn push(args: &Push) -> Result<Outcome> {
    let model = Model::read(&args.file).map_err(|e| Failure::in_file(&args.file, e))?;
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
    let refused = settle(&mut session, &wanted)?;
    let saved =
        if refused.is_empty() { session.command(&format!("preset save {name}")) } else { Ok(String::new()) };
    if !refused.is_empty() || saved.is_err() {
        // as it was
        for id in &kept {
            session.command(&format!("set {id} off"))?;
        }
        settle(&mut session, &before)?;
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
    for line in listing.iter().filter(|line| line.starts_with("  ")) {
        let mut words = line.split_whitespace();
        let (Some(name), Some(value)) = (words.next(), words.next()) else { continue };
        let unit = words.next().map_or_else(String::new, |unit| format!(" # {unit}"));
        let value = if value.parse::<f64>().is_ok() { value.to_owned() } else { format!("\"{value}\"") };
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
        assert_eq!(settle(&mut session, &wanted).expect("a line"), Vec::<String>::new());
        let after = values(&session.exchange("get").expect("a listing"));
        assert!(after.contains(&("k_vc".into(), "20000".into())), "{after:?}");
        session.command("set stribeck off").expect("taken");
        assert_eq!(settle(&mut session, &before).expect("a line"), Vec::<String>::new());
        assert_eq!(values(&session.exchange("get").expect("a listing")), before);
    }

    #[test]
    fn what_is_refused_for_good_is_told() {
        let mut session = Session::open("sim", 1).expect("a virtual device");
        let refused = settle(&mut session, &[("k_vc".into(), "1e9".into())]).expect("a line");
        assert_eq!(refused.len(), 1);
        assert!(refused[0].contains("k_vc"), "{refused:?}");
    }
}
