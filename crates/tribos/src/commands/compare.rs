//! `tribos compare REAL RENDERED`: does the rendered block feel like the real one?

use super::demo::fresh_folder;
use crate::failure::{Failure, Outcome, Result};
use crate::options::{self, Mapping};
use crate::terminal::Terminal;
use crate::{files, reading};
use compare::{
    Comparison, Kind, MARGIN, Measured, PlanarComparison, PlanarMeasured, PlanarPoint, TextureComparison,
    Verdict, asked, compare, compare_planar,
};
use identify::Model;
use identify::planar::PlanarModel;
use procedures::planar::Recordings;
use procedures::{library, rendered};
use report::number::number;
use report::{Table, overlay, planar_overlay};
use signals::{PlanarRecording, Recording};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Options of `compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  tribos compare real.csv rendered.csv --bare bare.csv --out overlay.svg
  tribos compare real.csv rendered.csv --expect same
  tribos compare washboard rendered.csv --bare bare.csv
  tribos compare --demo")]
pub struct Args {
    /// The real block, moved by the device or by a hand: any file that identify reads; signals named with their units, or by --map.
    /// Also a model, or a preset by its name: the force it asks for along the motion of the other
    #[arg(value_name = "REAL", required_unless_present = "demo")]
    real: Option<PathBuf>,
    /// The rendered block, moved by a hand. Also a model or a preset
    #[arg(value_name = "RENDERED", required_unless_present = "demo")]
    rendered: Option<PathBuf>,
    /// The device alone (preset `baseline`), moved as for RENDERED: its own resistance is subtracted
    #[arg(long, value_name = "BARE")]
    bare: Option<PathBuf>,
    /// Largest relative difference of friction that counts as the same
    #[arg(long, value_name = "SHARE", default_value_t = MARGIN, value_parser = options::above_zero, allow_hyphen_values = true)]
    margin: f64,
    /// Exit with 1 unless this is the verdict, of friction and of texture together
    #[arg(long, value_name = "VERDICT")]
    expect: Option<Expected>,
    /// Draw both: friction over velocity and time, difference in JND
    #[arg(long, value_name = "overlay.svg")]
    out: Option<PathBuf>,
    /// Write the comparison as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Brass, Teflon and rubber on the virtual device, rendered correctly and a tenth wrong; --out is then a folder
    #[arg(long, conflicts_with_all = ["real", "rendered", "bare", "expect", "json", "margin", "maps", "joint"])]
    demo: bool,
    /// Seed of the demo's noise
    #[arg(long, default_value_t = 1, requires = "demo")]
    seed: u64,
    #[command(flatten)]
    mapping: Mapping,
}

/// A verdict to be expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Expected {
    /// The ratio's interval is within the margin
    Same,
    /// It is wholly beyond the margin
    Different,
    /// Neither
    Undecided,
}

impl From<Expected> for Verdict {
    fn from(expected: Expected) -> Self {
        match expected {
            Expected::Same => Self::Same,
            Expected::Different => Self::Different,
            Expected::Undecided => Self::Undecided,
        }
    }
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    let (Some(real), Some(rendered)) = (&args.real, &args.rendered) else {
        return show_demo(args);
    };
    for path in [&args.out, &args.json].into_iter().flatten() {
        files::check_writable(path)?;
    }
    let paths: Vec<&PathBuf> = [real, rendered].into_iter().chain(&args.bare).collect();
    let asking = [real, rendered].map(|path| model_on_a_line(path));
    if asking.iter().any(Option::is_some) {
        let [real, rendered] = asking.map(Option::transpose);
        let recordings = beside_a_model(args, &paths, [real?, rendered?])?;
        return on_a_line(args, &recordings);
    }
    let planar =
        |path: &&&PathBuf| std::fs::read_to_string(path).is_ok_and(|text| PlanarModel::is_planar(&text));
    let models: Vec<&&PathBuf> = paths.iter().filter(planar).collect();
    let files: Vec<&&PathBuf> = paths.iter().filter(|path| !models.contains(path)).collect();
    let recordings = match (reading::read_any(&files, &args.mapping), models.first()) {
        (_, Some(_)) if files.is_empty() => return in_the_plane(args, &paths, Vec::new()),
        (read, model) => match (read?, model) {
            (Recordings::Plane(recordings), _) => return in_the_plane(args, &paths, recordings),
            (Recordings::Line(_), Some(model)) => {
                let (line, model) = (files[0].display(), model.display());
                return Err(Failure::new(format!(
                    "{line}: is on a line, and {model} is a model in the plane"
                ))
                .help("accepted beside it are recordings and models in the plane"));
            }
            (Recordings::Line(recordings), None) => recordings,
        },
    };
    on_a_line(args, &recordings)
}

/// A model on a line: a preset by its name, or a file with one.
fn model_on_a_line(path: &Path) -> Option<Result<Model>> {
    let named = !path.exists() && path.to_str().and_then(library::find).is_some();
    let is_file = path.extension().is_some_and(|e| e == "toml")
        && std::fs::read_to_string(path).is_ok_and(|text| !PlanarModel::is_planar(&text));
    (named || is_file).then(|| Ok(library::read(path)?))
}

/// Recordings of `paths` in their order; in the place of a model, what it asks for along the motion of the other.
fn beside_a_model(args: &Args, paths: &[&PathBuf], models: [Option<Model>; 2]) -> Result<Vec<Recording>> {
    let (model, at) = match models {
        [Some(model), None] => (model, 0),
        [None, Some(model)] => (model, 1),
        _ => {
            let (one, other) = (paths[0].display(), paths[1].display());
            return Err(Failure::new(format!(
                "{one} and {other}: two models have no motion to be compared at"
            ))
            .help("a recording and a model are accepted, and two recordings"));
        }
    };
    let files: Vec<&&PathBuf> =
        paths.iter().enumerate().filter(|(k, _)| *k != at).map(|(_, path)| path).collect();
    let planar = |text: String| PlanarModel::is_planar(&text);
    let in_the_plane = |file: &Path| {
        Failure::new(format!(
            "{}: is in the plane, and {} is a model on a line",
            file.display(),
            paths[at].display()
        ))
        .help("accepted beside it are recordings on a line")
    };
    if let Some(file) = files.iter().find(|file| std::fs::read_to_string(file).is_ok_and(planar)) {
        return Err(in_the_plane(file));
    }
    let Recordings::Line(mut recordings) = reading::read_any(&files, &args.mapping)? else {
        return Err(in_the_plane(files[0]));
    };
    let asked = asked(&model, &recordings[0])?;
    recordings.insert(at, asked);
    Ok(recordings)
}

fn on_a_line(args: &Args, recordings: &[Recording]) -> Result<Outcome> {
    let measured: Vec<Measured> =
        recordings.iter().map(Measured::new).collect::<std::result::Result<_, _>>()?;
    let (real, rendered, bare) = (&measured[0], &measured[1], measured.get(2));
    let comparison = compare(real, rendered, bare, args.margin)?;
    if let Some(path) = &args.out {
        files::write(path, overlay(&comparison, real, rendered)?.as_bytes())?;
    }
    if let Some(path) = &args.json {
        files::write_json(path, &comparison)?;
    }
    if args.json.as_deref() != Some(Path::new("-")) {
        print!("{}", text(&comparison));
        written(args);
    }
    Ok(outcome(args, comparison.overall()))
}

fn outcome(args: &Args, verdict: Verdict) -> Outcome {
    match args.expect {
        Some(expected) if Verdict::from(expected) != verdict => Outcome::ExpectedFindingAbsent,
        _ => Outcome::Done,
    }
}

/// `recordings` are those of `paths` that are no models, in their order.
fn in_the_plane(args: &Args, paths: &[&PathBuf], recordings: Vec<PlanarRecording>) -> Result<Outcome> {
    let mut recordings = recordings.into_iter();
    let mut one = |path: &PathBuf| {
        if std::fs::read_to_string(path).is_ok_and(|text| PlanarModel::is_planar(&text)) {
            let model = PlanarModel::read(path).map_err(|e| Failure::in_file(path, e))?;
            return Ok(PlanarMeasured::of_model(path.display().to_string(), model));
        }
        let recording = recordings.next().unwrap_or_default();
        Ok::<_, Failure>(PlanarMeasured::new(&recording)?)
    };
    let measured: Vec<PlanarMeasured> = paths.iter().map(|path| one(path)).collect::<Result<_>>()?;
    let comparison = compare_planar(&measured[0], &measured[1], measured.get(2), args.margin)?;
    if let Some(path) = &args.out {
        files::write(path, planar_overlay(&comparison)?.as_bytes())?;
    }
    if let Some(path) = &args.json {
        files::write_json(path, &comparison)?;
    }
    if args.json.as_deref() != Some(Path::new("-")) {
        print!("{}", planar_text(&comparison));
        written(args);
    }
    Ok(outcome(args, comparison.verdict))
}

fn written(args: &Args) {
    for (what, path) in [("overlay", &args.out), ("json", &args.json)] {
        if let Some(path) = path {
            println!("  {what}: {}", path.display());
        }
    }
}

/// Faults and notes, a line each.
fn remarks(faults: &[(String, String)], notes: &[String]) -> String {
    let faults = faults.iter().map(|(file, why)| format!("  ! {file}: {why}\n"));
    faults.chain(notes.iter().map(|note| format!("  {note}\n"))).collect()
}

/// What a hand makes of a distance in JND.
fn felt([low, high]: [f64; 2]) -> &'static str {
    if high < 1.0 {
        "a hand does not notice it"
    } else if low > 1.0 {
        "a hand notices it"
    } else {
        "at the border of what a hand notices"
    }
}

fn said(verdict: Verdict, margin: f64) -> String {
    let margin = 100.0 * margin;
    match verdict {
        Verdict::Same => format!("the same within {margin} %"),
        Verdict::Different => format!("different by more than {margin} %"),
        Verdict::Undecided => format!("not decided at {margin} %: a longer recording narrows the interval"),
    }
}

fn planar_text(c: &PlanarComparison) -> String {
    let mut out = remarks(&c.faults, &c.notes);
    let mut table = Table::new(&[
        ">motion °",
        ">mm/s",
        ">real N",
        ">rendered N",
        ">times the real",
        ">JND N",
        ">difference in JND",
        ">points elsewhere by °",
        ">in JND",
    ]);
    let size = |f: [f64; 2]| f[0].hypot(f[1]);
    let middle = c.points.len() / 3..2 * c.points.len() / 3;
    for p in &c.points[middle] {
        table.row([
            format!("{:+.0}", p.direction.to_degrees()),
            format!("{:.1}", 1e3 * p.speed),
            number(size(p.real), 4),
            number(size(p.rendered), 4),
            format!("{:.3} ± {:.3}", p.ratio.value, p.ratio.value - p.ratio.ci95[0]),
            number(p.jnd, 2),
            format!("{:+.3}", p.level_jnd),
            format!("{:+.1}", p.turned.to_degrees()),
            format!("{:+.3}", p.turned_jnd),
        ]);
    }
    out += &table.render();
    let [low, high] = c.distance.ci95;
    let _ = writeln!(
        out,
        "  distance {:.2} JND ({low:.2} to {high:.2}): {}",
        c.distance.value,
        felt(c.distance.ci95)
    );
    let end = |p: &PlanarPoint| {
        let [low, high] = p.ratio.ci95;
        format!("{:.3} ({low:.3} to {high:.3}) at {:+.0}°", p.ratio.value, p.direction.to_degrees())
    };
    let _ = writeln!(
        out,
        "  friction {} to {} times the real: {}",
        end(&c.least),
        end(&c.most),
        said(c.verdict, c.margin)
    );
    out
}

fn text(c: &Comparison) -> String {
    let mut out = remarks(&c.faults, &c.notes);
    let mut table =
        Table::new(&[">mm/s", ">real N", ">rendered N", ">± N", ">JND N", ">difference in JND", ">weight"]);
    for p in &c.points {
        table.row([
            format!("{:+.1}", 1e3 * p.velocity),
            number(p.real, 4),
            number(p.rendered, 4),
            number(1.96 * p.std, 2),
            number(p.jnd, 2),
            format!("{:+.3}", (p.rendered - p.real) / p.jnd),
            format!("{:.2}", p.weight),
        ]);
    }
    out.push_str(&table.render());
    for b in &c.breakaway {
        let _ = writeln!(
            out,
            "  break-away {}: {:.3} N real, {:.3} ± {:.3} N rendered, {:+.3} JND",
            b.direction,
            b.real,
            b.rendered,
            1.96 * b.std,
            (b.rendered - b.real) / b.jnd
        );
    }
    if c.breakaway.is_empty() {
        out.push_str("  break-away: not found in both recordings, not in the distance\n");
    }
    if let [Some(real), Some(rendered)] = c.mass {
        let _ =
            writeln!(out, "  moving mass {real:.3} kg real, {rendered:.3} kg rendered; not in the distance");
    }
    let [low, high] = c.distance.ci95;
    let _ = writeln!(
        out,
        "  distance {:.2} JND ({low:.2} to {high:.2}): {}",
        c.distance.value,
        felt(c.distance.ci95)
    );
    let [low, high] = c.ratio.ci95;
    let _ = writeln!(
        out,
        "  friction {:.3} times the real ({low:.3} to {high:.3}): {}",
        c.ratio.value,
        said(c.verdict, c.margin)
    );
    if let Some(texture) = &c.texture {
        out += &texture_text(texture, c.margin);
    }
    out
}

/// Force over position, a line each for directions, period, kind and distance.
fn texture_text(t: &TextureComparison, margin: f64) -> String {
    let mut out = String::new();
    for d in &t.directions {
        let _ = write!(
            out,
            "  texture {}: {:.3} N real, {:.3} ± {:.3} N rendered, {:+.2} JND",
            d.direction,
            d.real,
            d.rendered,
            1.96 * d.std,
            (d.rendered - d.real) / d.jnd
        );
        if let Some(ratio) = d.ratio {
            let [low, high] = ratio.ci95;
            let _ = write!(out, ", {:.3} times ({low:.3} to {high:.3})", ratio.value);
        }
        if let Some(overlap) = d.overlap {
            let [low, high] = overlap.ci95;
            let _ = write!(out, ", shape {:.3} ({low:.3} to {high:.3})", overlap.value);
        }
        out.push('\n');
    }
    let kind = |kind: Option<Kind>| match kind {
        Some(Kind::Force) => ", a force",
        Some(Kind::Friction) => ", a friction",
        None => "",
    };
    let one = |k: usize| match t.period[k] {
        Some(period) => format!("{:.3} mm{}", 1e3 * period, kind(t.kind[k])),
        None => "none".into(),
    };
    let _ = write!(out, "  texture period: real {}; rendered {}", one(0), one(1));
    if let Some(ratio) = t.period_ratio {
        let [low, high] = ratio.ci95;
        let _ = write!(out, "; {:.4} times ({low:.4} to {high:.4})", ratio.value);
    }
    let [low, high] = t.distance.ci95;
    let _ = writeln!(
        out,
        "\n  texture distance {:.2} JND ({low:.2} to {high:.2}): {}; {}",
        t.distance.value,
        felt(t.distance.ci95),
        said(t.verdict, margin)
    );
    out
}

fn show_demo(args: &Args) -> Result<Outcome> {
    let out = args.out.clone().unwrap_or_else(|| fresh_folder("tribos-compare"));
    println!(
        "A real block of the virtual rig, driven and identified; the handle then renders what was identified, with a"
    );
    println!("simulated hand on it: as found, and with a tenth too much and too little friction.\n");
    let all = rendered::demo(&out, args.seed, &Terminal)?;
    let mut table =
        Table::new(&["material", ">friction", ">JND", ">95 %", ">times the real", ">95 %", "verdict"]);
    for r in &all {
        let c = &r.comparison;
        let ci = |[low, high]: [f64; 2]| format!("{low:.3} … {high:.3}");
        table.row([
            r.material.to_owned(),
            format!("× {}", r.times),
            format!("{:.3}", c.distance.value),
            ci(c.distance.ci95),
            format!("{:.3}", c.ratio.value),
            ci(c.ratio.ci95),
            format!("{:?}", c.verdict).to_lowercase(),
        ]);
    }
    print!("{}", table.render());
    println!("\n  recordings, models and overlays: {}", out.display());
    Ok(Outcome::Done)
}
