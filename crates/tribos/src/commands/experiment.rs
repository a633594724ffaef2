//! `tribos experiment analyse|simulate`: the perception experiments of chapter 5.

use crate::failure::{Failure, Outcome, Result};
use crate::files;
use crate::options;
use crate::progress::Progress;
use clap::Subcommand;
use perception::study::{self, Analysis, POOLED, Shown};
use perception::{ForcedChoicePlan, Header, Margins, Record, Resistance, SimulatedSubject, TargetingPlan};
use rayon::prelude::*;
use report::Table;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Options of `experiment`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// What sessions say: differences from the baseline, throughput, psychometric functions
    Analyse(Analyse),
    /// Simulated subjects through the whole experiment; their files say that no human made them
    Simulate(Simulate),
}

#[derive(Debug, clap::Args)]
struct Analyse {
    /// Sessions (.jsonl), or folders of them
    #[arg(required = true, value_name = "SESSION")]
    sessions: Vec<PathBuf>,
    /// Smallest change in completion time that counts, s
    #[arg(long, value_name = "S", default_value_t = Margins::THESIS.time_s, value_parser = options::above_zero, allow_hyphen_values = true)]
    time_margin: f64,
    /// Smallest change in the number of errors that counts
    #[arg(long, value_name = "N", default_value_t = Margins::THESIS.errors, value_parser = options::above_zero, allow_hyphen_values = true)]
    error_margin: f64,
    /// Smallest change in the mean error magnitude that counts, mm of handle travel
    #[arg(long, value_name = "MM", default_value_t = Margins::THESIS.error_mm, value_parser = options::above_zero, allow_hyphen_values = true)]
    magnitude_margin: f64,
    /// Folder for tidy CSV, ready for psignifit, R or pandas
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write a self-contained HTML report
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the analysis as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
struct Simulate {
    /// Number of subjects
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    subjects: u32,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for their sessions
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    match &args.action {
        Action::Analyse(args) => analyse(args),
        Action::Simulate(args) => simulate(args),
    }
}

fn folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path)
        .map_err(|e| Failure::in_file(path, format!("cannot be made a folder: {}", files::reason(&e))))
}

fn simulate(args: &Simulate) -> Result<Outcome> {
    folder(&args.out)?;
    let bar = Progress::new("simulating");
    let done = AtomicUsize::new(0);
    let one = |number: u32| -> Result<()> {
        let subject = SimulatedSubject::drawn(number as usize, args.seed);
        let seed = subject.seed;
        let file = |kind: &str| args.out.join(format!("{}-{kind}.jsonl", subject.id));
        let (header, records) = subject.targeting(TargetingPlan::thesis(seed)).map_err(Failure::new)?;
        write_session(&file("targeting"), &header, &records)?;
        let (header, records) = subject.forced_choice(ForcedChoicePlan::thesis(seed));
        write_session(&file("forced-choice"), &header, &records)?;
        let (header, records) = subject.forced_choice(ForcedChoicePlan::adaptive(seed));
        write_session(&file("adaptive"), &header, &records)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        bar.set(done as f32 / args.subjects as f32, "");
        Ok(())
    };
    (1..=args.subjects).into_par_iter().try_for_each(one)?;
    drop(bar);
    println!(
        "{}: {} simulated subjects, three sessions each; a model made them, no human did",
        args.out.display(),
        args.subjects
    );
    println!("  tribos experiment analyse {0} --report {0}/report.html", args.out.display());
    Ok(Outcome::Done)
}

fn write_session(path: &Path, header: &Header, records: &[Record]) -> Result<()> {
    let mut text = serde_json::to_string(header).map_err(Failure::new)?;
    for record in records {
        text.push('\n');
        text.push_str(&serde_json::to_string(record).map_err(Failure::new)?);
    }
    text.push('\n');
    files::write(path, text.as_bytes())
}

fn analyse(args: &Analyse) -> Result<Outcome> {
    for path in [&args.report, &args.json].into_iter().flatten() {
        files::check_writable(path)?;
    }
    let sessions = study::read(&args.sessions)?;
    if let Some(dir) = &args.out {
        folder(dir)?;
    }
    let margins =
        Margins { time_s: args.time_margin, errors: args.error_margin, error_mm: args.magnitude_margin };
    let analysis = study::analyse(&sessions, margins);
    if let Some(dir) = &args.out {
        for (name, text) in study::tables(&sessions, &analysis) {
            files::write(&dir.join(name), text.as_bytes())?;
        }
    }
    if let Some(path) = &args.report {
        files::write(path, report::sessions(&analysis)?.as_bytes())?;
    }
    if let Some(path) = &args.json {
        files::write_json(path, &analysis)?;
    }
    if args.json.as_deref() != Some(Path::new("-")) {
        print!("{}", text(&analysis));
        for (what, path) in [("tables", &args.out), ("report", &args.report), ("json", &args.json)] {
            if let Some(path) = path {
                println!("  {what}: {}", path.display());
            }
        }
    }
    Ok(Outcome::Done)
}

/// The analysis as people read it.
pub(crate) fn text(a: &Analysis) -> String {
    let mut out = String::new();
    let n = a.subjects.len();
    let s = a.plural();
    if a.simulated {
        let _ = writeln!(out, "  {n} SIMULATED subject{s}: a model made these data, no human did");
    } else {
        let _ = writeln!(out, "  {n} subject{s}");
    }
    a.notes.iter().for_each(|note| out.push_str(&format!("  {note}\n")));
    if !a.counts.is_empty() {
        let mut table =
            Table::new(&["reported by the thesis, on narrow targets", ">change", ">95 %", "here"]);
        for c in &a.claims {
            let shown = match c.shown {
                Shown::Yes => "shown",
                Shown::Open => "not shown",
                Shown::Contradicted => "contradicted",
            };
            table.row([
                c.claim.to_owned(),
                format!("{:+.1} {}", c.mean, c.unit),
                format!("{:+.1} to {:+.1}", c.ci95[0], c.ci95[1]),
                shown.to_owned(),
            ]);
        }
        let _ = write!(out, "\n{}", table.render());
        let heads = [
            "index",
            "resistance",
            ">time better",
            ">worse",
            ">errors better",
            ">worse",
            ">mm better",
            ">worse",
            ">time",
            ">errors",
        ];
        let mut table = Table::new(&heads);
        for c in &a.counts {
            table.row([
                c.index.to_string(),
                c.resistance.name().to_owned(),
                c.time.better.to_string(),
                c.time.worse.to_string(),
                c.errors.better.to_string(),
                c.errors.worse.to_string(),
                c.error_mm.better.to_string(),
                c.error_mm.worse.to_string(),
                format!("{:+.0} %", 100.0 * c.slower),
                format!("{:+.1}", c.more_errors),
            ]);
        }
        let _ = write!(out, "\n{}", table.render());
        let mut table = Table::new(&["resistance", ">throughput bit/s", ">effective width mm"]);
        for r in Resistance::ALL {
            if let Some((bits, width)) = study::mean_throughput(a, r) {
                table.row([r.name().to_owned(), format!("{bits:.2}"), format!("{width:.2}")]);
            }
        }
        let _ = write!(out, "\n{}", table.render());
    }
    if !a.rings.is_empty() {
        let mut table = Table::new(&["surface", ">throughput bit/s", ">effective width mm"]);
        for (surface, bits, width) in study::surfaces(a) {
            table.row([surface.to_owned(), format!("{bits:.2}"), format!("{width:.2}")]);
        }
        let _ = write!(out, "\n{}", table.render());
    }
    if !a.psychometric.is_empty() {
        let mut table = Table::new(&["batch", "subject", ">answers", "JND, 95 %"]);
        for f in a.psychometric.iter().filter(|f| f.subject == POOLED || n <= 3) {
            let answers: u32 = f.fit.levels.iter().map(|l| l.answers).sum();
            let subject = if f.subject == POOLED { "all together" } else { &f.subject };
            table.row([
                f.batch.clone(),
                subject.to_owned(),
                answers.to_string(),
                report::threshold(&f.fit.threshold),
            ]);
        }
        let _ = write!(out, "\n{}", table.render());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simulated_subjects_go_all_the_way_and_every_output_says_what_they_are() {
        let dir = tempfile::tempdir().expect("a folder");
        let out = dir.path().join("subjects");
        simulate(&Simulate { subjects: 2, seed: 1, out: out.clone() }).unwrap_or_else(|e| panic!("{e}"));
        let sessions = study::read(std::slice::from_ref(&out)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(sessions.len(), 6);
        let analysis = study::analyse(&sessions, Margins::THESIS);
        let said = text(&analysis);
        println!("{said}");
        assert!(said.contains("no human did"));
        assert_eq!(analysis.counts.len(), 36, "nine indices, four resistances");
        assert!(report::sessions(&analysis).unwrap_or_default().contains("no human did"));
        let tables = study::tables(&sessions, &analysis);
        assert_eq!(tables.len(), 7);
        for (name, table) in &tables {
            let columns = table.lines().next().unwrap_or_default().split(',').count();
            assert!(table.lines().all(|line| line.split(',').count() == columns), "{name}");
            assert!(table.lines().skip(1).all(|line| line.contains(",true,")), "{name}: no word of a model");
        }
        let json = serde_json::to_value(&analysis).expect("json");
        assert_eq!(json["simulated"], true);
        // people and models do not mix
        let mut person = std::fs::read_to_string(out.join("simulated-01-forced-choice.jsonl")).expect("text");
        let at = person.find(",\"simulated\":{").expect("a mark");
        let end = at + person[at..].find("]]}").expect("its end") + 3;
        person.replace_range(at..end, "");
        std::fs::write(out.join("zz-person.jsonl"), person).expect("written");
        let why = study::read(&[out]).err().map(|e| e.to_string()).unwrap_or_default();
        println!("{why}");
        assert!(why.contains("not analysed together"));
    }
}
