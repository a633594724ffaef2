//! `tribos diagnose REC…`

use crate::failure::{Failure, Outcome, Result};
use crate::options::{Recordings, Results};
use crate::progress::Progress;
use crate::{files, reading};
use diagnose::{Diagnosis, FreeFormFinding, Nuisance, Options, Verdict, diagnose, diagnose_planar};
use procedures::planar::{self, Recordings as Recorded};
use procedures::{diagnosed, recordings};
use report::Table;
use report::number::{number, with_std};
use std::path::PathBuf;

/// Options of `diagnose`.
#[derive(Debug, clap::Args)]
#[command(after_long_help = effects_help())]
pub struct Args {
    #[command(flatten)]
    recordings: Recordings,
    /// Recordings that are only predicted, to judge the findings
    #[arg(long, value_name = "REC", num_args = 1..)]
    validate: Vec<PathBuf>,
    /// Standard deviation of one force sample, N (N·m); estimated when not given
    #[arg(long, value_name = "N", value_parser = crate::options::noise, allow_hyphen_values = true)]
    noise: Option<f64>,
    /// Cut-off of the zero-phase filter, Hz; chosen from the noise when not given
    #[arg(long, value_name = "HZ", value_parser = crate::options::cutoff, allow_hyphen_values = true)]
    cutoff: Option<f64>,
    /// What differs between the recordings: offset (of the force), origin (of the position), friction (its level).
    /// Everything else is shared; on --validate recordings these are fitted again, beside the frozen figure
    #[arg(long, value_name = "NUISANCE", value_delimiter = ',', value_parser = diagnosed::nuisance)]
    per_recording: Vec<Nuisance>,
    /// The encoder is absolute, or was homed: phases along the stroke hold on --validate recordings
    #[arg(long)]
    absolute: bool,
    /// Effects to leave out of the search
    #[arg(long, value_name = "EFFECT", value_delimiter = ',')]
    exclude: Vec<String>,
    /// Exit with 1 unless this is found: an effect, or a verdict (mismatch, no_mismatch, not_testable)
    #[arg(long, value_name = "FINDING")]
    expect: Option<String>,
    #[command(flatten)]
    results: Results,
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    args.results.check()?;
    let options = Options {
        declared_noise: args.noise,
        cutoff_hz: args.cutoff,
        exclude: args.exclude.clone(),
        per_recording: args.per_recording.clone(),
        absolute: args.absolute,
        ..Options::default()
    };
    diagnosed::check(&options, args.recordings.files.len() + args.validate.len())?;
    if let Some(finding) = &args.expect {
        diagnosed::check_finding(finding)?;
    }
    let files: Vec<&PathBuf> = args.recordings.files.iter().chain(&args.validate).collect();
    let mut train = match reading::read_any(&files, &args.recordings.mapping)? {
        Recorded::Line(recordings) => recordings,
        Recorded::Plane(recordings) => return in_the_plane(args, &options, recordings),
    };
    let validate = train.split_off(args.recordings.files.len());
    let found = {
        let bar = Progress::new("diagnosing");
        diagnose(&train, &validate, &options, &|share, what| bar.set(share, what)).map_err(Failure::new)?
    };
    let name = train.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", ");
    if let Some(path) = &args.results.out {
        let model = found.model.as_ref().ok_or_else(|| {
            Failure::new(format!(
                "--out {}: {name} is not testable, so there is no model to write",
                path.display()
            ))
            .help(found.summary.clone())
        })?;
        let model = identify::Model { name: recordings::model_name(&train), ..model.clone() };
        files::write(path, model.to_toml().as_bytes())?;
    }
    if let Some(path) = &args.results.report {
        files::write(path, report::diagnosis(&found, &name).as_bytes())?;
    }
    if let Some(path) = &args.results.json {
        files::write_json(path, &found)?;
    }
    if !args.results.json_on_stdout() {
        print!("{}", describe(&name, &found));
        print!("{}", args.results.written());
    }
    Ok(match &args.expect {
        Some(finding) if !is_there(&found, finding) => Outcome::ExpectedFindingAbsent,
        _ => Outcome::Done,
    })
}

fn in_the_plane(
    args: &Args,
    options: &Options,
    mut recordings: Vec<signals::PlanarRecording>,
) -> Result<Outcome> {
    let validate = recordings.split_off(args.recordings.files.len());
    let main = {
        let bar = Progress::new("diagnosing");
        diagnose_planar(&recordings, &validate, options, &|share, what| bar.set(share, what))
            .map_err(Failure::new)?
    };
    let found = &main.found;
    let name = recordings.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", ");
    if let Some(path) = &args.results.out {
        let model = planar::model(&main, &recordings).ok_or_else(|| {
            Failure::new(format!(
                "--out {}: a model in the plane holds mass, level by direction, viscous friction and offset only",
                path.display()
            ))
            .help(found.summary.clone())
        })?;
        files::write(path, model.to_toml().as_bytes())?;
    }
    if let Some(path) = &args.results.report {
        files::write(path, report::diagnosis(found, &name).as_bytes())?;
    }
    if let Some(path) = &args.results.json {
        files::write_json(path, found)?;
    }
    if !args.results.json_on_stdout() {
        print!("{}", describe(&name, found));
        print!("{}", args.results.written());
    }
    Ok(match &args.expect {
        Some(finding) if !is_there(found, finding) => Outcome::ExpectedFindingAbsent,
        _ => Outcome::Done,
    })
}

fn verdict(found: &Diagnosis) -> &'static str {
    match found.verdict {
        Verdict::Mismatch => "mismatch",
        Verdict::NoMismatch => "no_mismatch",
        Verdict::NotTestable => "not_testable",
    }
}

pub(crate) fn is_there(found: &Diagnosis, finding: &str) -> bool {
    verdict(found) == finding || found.missing.iter().chain(&found.instruments).any(|m| m.effect == finding)
}

/// Every effect that a diagnosis can name, for the help.
fn effects_help() -> String {
    let mut out = String::from("Effects:\n");
    let line = diagnose::effect_ids();
    let planar = diagnose::planar_effect_ids().into_iter().filter(|id| !line.contains(id));
    for about in line.iter().copied().chain(planar).filter_map(friction::effects::about) {
        out += &format!("  {:28} {}\n", about.id, about.says);
    }
    out
}

/// The diagnosis without its details: where it goes wrong and what was left out.
pub(crate) fn outline(name: &str, found: &Diagnosis) -> String {
    let unit = found.noise_floor.unit.as_str();
    let mut out = format!("{name}: {}\n{}\n", verdict(found), found.summary);
    for fault in &found.recording_faults {
        out += &format!("  fault of the recording: {}\n", fault.why);
    }
    if found.verdict == Verdict::NotTestable {
        return out;
    }
    out += &format!(
        "  noise floor {} {unit} ({}), filter {} Hz; held-out error {} {unit} before, {} {unit} after\n",
        number(found.noise_floor.rms, 3),
        found.noise_floor.how,
        number(found.cutoff_hz, 3),
        number(found.baseline.rms_heldout, 4),
        number(found.after.rms_heldout, 4)
    );
    if found.fitted_share < 1.0 {
        out += &format!(
            "  fitted: parts spread evenly over the recording, {:.0} % of its samples\n",
            100.0 * found.fitted_share
        );
    }
    let mut where_ = Table::new(&["where it goes wrong", ">from", ">to", "unit", ">share", ">p"]);
    for l in found.location.iter().take(6) {
        where_.row([
            l.coordinate.replace('_', " "),
            number(l.from, 3),
            number(l.to, 3),
            l.unit.clone(),
            format!("{:.0} %", 100.0 * l.share_of_mismatch),
            number(l.p, 1),
        ]);
    }
    if !where_.is_empty() {
        out += &where_.render();
    }
    let mut named = Table::new(&[
        "left out",
        ">held-out before",
        ">after",
        &format!("gain, 95 %, {unit}"),
        "as well explained by",
    ]);
    for m in &found.missing {
        named.row([
            m.effect.clone(),
            number(m.rms_heldout_before, 4),
            number(m.rms_heldout_after, 4),
            format!("{} … {}", number(m.gain_ci95[0], 3), number(m.gain_ci95[1], 3)),
            if m.indistinguishable_from.is_empty() {
                "nothing else".into()
            } else {
                m.indistinguishable_from.join(", ")
            },
        ]);
    }
    if !named.is_empty() {
        out += &named.render();
    }
    out
}

/// What is known of physics that has no name.
fn free_form(form: &FreeFormFinding, experiment: &str) -> String {
    let mut out = String::new();
    if let Some(hint) = &form.looks_like {
        out += &format!("    looks like gain*{}\n", hint.formula);
        for (name, q) in &hint.parameters {
            out += &format!("      {name} = {} {}\n", number(q.value, 4), q.unit);
        }
        out += &format!("      usually made by {}\n", hint.made_by);
    }
    if !form.kin.is_empty() {
        out += &format!("    named at first, and needless beside it: {}\n", form.kin.join(", "));
    }
    out + &format!("    to learn more: {experiment}\n")
}

/// The diagnosis as people read it.
pub(crate) fn describe(name: &str, found: &Diagnosis) -> String {
    let unit = found.noise_floor.unit.as_str();
    let mut out = outline(name, found);
    if found.verdict == Verdict::NotTestable {
        return out;
    }
    for m in &found.missing {
        out += &format!("  {}: {}\n    {}\n", m.effect, m.says, m.equation);
        for (name, q) in &m.parameters {
            let (value, std) = with_std(q.value, q.std);
            out += &format!("    {name} = {value} ± {std} {}\n", q.unit);
        }
        if !m.experiment.is_empty() && !m.indistinguishable_from.is_empty() {
            out += &format!("    to tell them apart: {}\n", m.experiment);
        }
        if let Some(form) = &m.free_form {
            out += &free_form(form, &m.experiment);
        }
    }
    for m in &found.instruments {
        let values: Vec<String> = m
            .parameters
            .iter()
            .map(|(name, q)| {
                let (value, std) = with_std(q.value, q.std);
                format!("{name} = {value} ± {std} {}", q.unit)
            })
            .collect();
        out += &format!("  instrument repaired, {}: {} ({})\n", m.effect, m.says, values.join(", "));
    }
    for w in &found.does_not_carry_over {
        out += &format!("  does not carry over, {}: {}", w.effect, w.regime);
        if w.rms_after.is_finite() {
            out += &format!(
                ", {} {unit} without it and {} {unit} with it",
                number(w.rms_before, 4),
                number(w.rms_after, 4)
            );
        }
        out += "\n";
    }
    for b in &found.blind_to {
        out += &format!("  blind to {}: {}\n    to see it: {}\n", b.effect, b.because, b.experiment);
    }
    if !found.rejected.is_empty() {
        let bounds: Vec<String> = found
            .rejected
            .iter()
            .map(|r| format!("{} < {} {}", r.effect, number(r.upper_bound, 2), r.unit))
            .collect();
        out += &format!("  ruled out: {}\n", bounds.join(", "));
    }
    for n in &found.nuisances {
        out += &format!("  {}: {} against the first recording\n", n.recording, nuisance_line(n));
    }
    for v in &found.validation {
        out += &format!(
            "  {} (not fitted): {} {unit} before, {} {unit} after ({:.2} % → {:.2} % of the force)\n",
            v.recording,
            number(v.rms_before, 4),
            number(v.rms_after, 4),
            100.0 * v.relative_before,
            100.0 * v.relative_after
        );
        if let (Some(before), Some(after)) = (v.rms_before_refitted, v.rms_after_refitted) {
            let again: Vec<String> = v.nuisances.iter().map(nuisance_line).collect();
            let again = if again.is_empty() { "nothing".into() } else { again.join(", ") };
            out += &format!(
                "    fitted again there, {again}: {} {unit} before, {} {unit} after\n",
                number(before, 4),
                number(after, 4)
            );
        }
    }
    out
}

fn nuisance_line(n: &diagnose::PerRecording) -> String {
    if n.std.is_nan() {
        return format!("{} not determined", n.nuisance);
    }
    let (value, std) = with_std(n.value, n.std);
    format!("{} {value} ± {std} {}", n.nuisance, n.unit)
}
