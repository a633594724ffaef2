//! `tribos identify REC…`

use crate::failure::{Failure, Outcome, Result};
use crate::options::{LawChoice, PreprocessChoice, Recordings, Results};
use crate::{files, reading};
use diagnose::Quantity;
use identify::{
    DahlOptions, Errors, Estimate, Identification, KarnoppOptions, Model, Preprocess, Signals, identify_dahl,
    identify_karnopp, prepare,
};
use report::number::{number, with_std};
use report::{Identified, Table, Undetermined};
use signals::{Preparation, Recording};

/// Options of `identify`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    recordings: Recordings,
    /// Friction law
    #[arg(long, value_enum, default_value_t)]
    law: LawChoice,
    /// How velocity and acceleration are derived
    #[arg(long, value_enum, default_value_t)]
    preprocess: PreprocessChoice,
    /// Cut-off of the default's filter, Hz; chosen from the noise when not given
    #[arg(long, value_name = "HZ", value_parser = crate::options::cutoff, allow_hyphen_values = true)]
    cutoff: Option<f64>,
    /// Δv: slower samples are excluded, m/s (rad/s); chosen from the data when not given
    #[arg(long, value_name = "M/S", value_parser = crate::options::not_negative, allow_hyphen_values = true)]
    delta_v: Option<f64>,
    /// Plain least squares [thesis, eq. 3.8] instead of Fuller's estimator [thesis, eq. 3.9]
    #[arg(long)]
    least_squares: bool,
    /// Exit with 1 unless this parameter was identified, e.g. sigma
    #[arg(long, value_name = "PARAMETER")]
    expect: Option<String>,
    #[command(flatten)]
    results: Results,
}

/// One fit and what it was made of.
struct Fit {
    signals: Signals,
    found: Identification,
}

fn fit(args: &Args, recording: &Recording, how: &Preprocess, preparations: &[Preparation]) -> Result<Fit> {
    let errors = if args.least_squares { Errors::LeastSquares } else { Errors::default() };
    let signals = prepare(recording, how).map_err(Failure::new)?;
    let mut found = match args.law {
        LawChoice::Karnopp => identify_karnopp(
            &signals,
            &KarnoppOptions { errors, delta_v: args.delta_v, ..KarnoppOptions::default() },
        ),
        LawChoice::Dahl => identify_dahl(&signals, &DahlOptions { errors, ..DahlOptions::default() }),
    }
    .map_err(Failure::new)?;
    if let [_, _, ..] = preparations {
        // several were joined: each has its own preparation, behind the cut-off of the fit
        let cutoff_hz = signals.preparation().cutoff_hz;
        found.preparation = preparations.iter().map(|p| Preparation { cutoff_hz, ..p.clone() }).collect();
        found.recording_faults = preparations.iter().flat_map(|p| p.faults.clone()).collect();
    }
    Ok(Fit { signals, found })
}

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    args.results.check()?;
    if args.law == LawChoice::Dahl && args.delta_v.is_some() {
        return Err(Failure::new("--delta-v: the law of Dahl has none; accepted with --law karnopp"));
    }
    if let Some(name) = &args.expect {
        check_parameter(args.law, name)?;
    }
    let recordings = reading::read_all(&args.recordings.files, &args.recordings.mapping)?;
    let (recording, preparations) = reading::joined(&recordings)?;
    let default = Preprocess::Tribos { cutoff_hz: args.cutoff };
    let how = match args.preprocess {
        PreprocessChoice::Tribos => default,
        PreprocessChoice::Emps => Preprocess::Emps,
        PreprocessChoice::Thesis => Preprocess::Thesis,
    };
    let main = fit(args, &recording, &how, &preparations)?;
    // what a published or a given preprocessing changes is seen beside the default
    let beside = if how == default { None } else { fit(args, &recording, &default, &preparations).ok() };
    let model = Model { name: model_name(&recordings), ..Model::from(&main.found) };
    if let Some(path) = &args.results.out {
        let text = model.to_toml();
        files::write(path, text.as_bytes())?;
    }
    if let Some(path) = &args.results.report {
        files::write(path, report::identification(&shown(&recording.name, &main, &model)).as_bytes())?;
    }
    if let Some(path) = &args.results.json {
        let text = main.found.to_json().map_err(Failure::new)?;
        files::write(path, format!("{text}\n").as_bytes())?;
    }
    if !args.results.json_on_stdout() {
        print!("{}", describe(&recording.name, &main.found, beside.as_ref().map(|fit| &fit.found)));
        print!("{}", args.results.written());
    }
    Ok(match &args.expect {
        Some(name) if !main.found.parameters.contains_key(name) => Outcome::ExpectedFindingAbsent,
        _ => Outcome::Done,
    })
}

/// Identifies by the defaults: the result as people read it, the report, and the model.
///
/// # Errors
/// What is wrong with the recordings.
pub(crate) fn by_defaults(files: &[std::path::PathBuf]) -> Result<(String, String, Model)> {
    let args = Args {
        recordings: Recordings { files: files.to_vec(), mapping: crate::options::Mapping::default() },
        law: LawChoice::default(),
        preprocess: PreprocessChoice::default(),
        cutoff: None,
        delta_v: None,
        least_squares: false,
        expect: None,
        results: Results::default(),
    };
    let recordings = reading::read_all(files, &args.recordings.mapping)?;
    let (recording, preparations) = reading::joined(&recordings)?;
    let fit = fit(&args, &recording, &Preprocess::Tribos { cutoff_hz: None }, &preparations)?;
    let model = Model { name: model_name(&recordings), ..Model::from(&fit.found) };
    let html = report::identification(&shown(&recording.name, &fit, &model));
    Ok((describe(&recording.name, &fit.found, None), html, model))
}

/// A parameter the law has.
fn check_parameter(law: LawChoice, name: &str) -> Result<()> {
    let known: &[&str] = match law {
        LawChoice::Karnopp => {
            &["mass", "coulomb_p", "coulomb_n", "viscous_p", "viscous_n", "static_p", "static_n", "delta_v"]
        }
        LawChoice::Dahl => &["mass", "viscous", "limit_p", "limit_n", "sigma"],
    };
    if known.contains(&name) {
        return Ok(());
    }
    Err(Failure::new(format!("--expect: the law has no parameter `{name}`"))
        .help(format!("accepted are {}", known.join(", "))))
}

/// A preset's name from the file's.
pub(crate) fn model_name(recordings: &[Recording]) -> String {
    let name = recordings.first().map_or("", |r| r.name.as_str());
    let stem = std::path::Path::new(name)
        .file_stem()
        .map(|s| s.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    let clean: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).take(24).collect();
    if clean.is_empty() { "identified".into() } else { clean }
}

/// The result as people read it.
pub(crate) fn describe(name: &str, found: &Identification, beside: Option<&Identification>) -> String {
    let mut out = format!("{name}: {} samples, law {}\n", found.samples, found.law);
    let mut heads = vec!["parameter", ">value", ">± std", "unit", "95 % interval"];
    if beside.is_some() {
        heads.extend([">default", ">± std"]);
    }
    let mut table = Table::new(&heads);
    let order = |name: &str| ORDER.iter().position(|known| *known == name).unwrap_or(ORDER.len());
    let mut parameters: Vec<(&String, &Estimate)> = found.parameters.iter().collect();
    parameters.sort_by_key(|(name, _)| order(name));
    for (name, p) in parameters {
        let (value, std) = with_std(p.value, p.std);
        let interval = format!("{} … {}", number(p.ci95[0], 5), number(p.ci95[1], 5));
        let mut row = vec![name.clone(), value, std, p.unit.clone(), interval];
        if let Some(beside) = beside {
            match beside.parameters.get(name) {
                Some(other) => {
                    let (value, std) = with_std(other.value, other.std);
                    row.extend([value, std]);
                }
                None => row.extend(["–".into(), "–".into()]),
            }
        }
        table.row(row);
    }
    out += &table.render();
    out += &format!(
        "  relative error {:.3} %, residual {} {} rms",
        100.0 * found.relative_error,
        number(found.residual_rms, 4),
        found.force_unit
    );
    if let Some(beside) = beside {
        out += &format!("; default {:.3} %", 100.0 * beside.relative_error);
    }
    out += &format!("\n  {}; {}\n", found.estimator, found.preprocess);
    for n in &found.not_identifiable {
        out += &format!("  not identifiable: {}: {}\n    try: {}\n", n.parameter, n.because, n.experiment);
    }
    for fault in &found.recording_faults {
        out += &format!("  fault of the recording: {}\n", fault.why);
    }
    out
}

/// Parameters in the order of [thesis, table 3-3].
const ORDER: [&str; 13] = [
    "mass",
    "coulomb_p",
    "coulomb_n",
    "viscous_p",
    "viscous_n",
    "coulomb",
    "viscous",
    friction::parameters::OFFSET.name,
    "static_p",
    "static_n",
    "delta_v",
    "limit_p",
    "limit_n",
];

fn shown(name: &str, fit: &Fit, model: &Model) -> Identified {
    let (signals, found) = (&fit.signals, &fit.found);
    let quantity = |p: &Estimate| Quantity { value: p.value, std: p.std, unit: p.unit.clone() };
    let mass = found.value("mass").unwrap_or(0.0);
    Identified {
        name: name.to_owned(),
        law: found.law.clone(),
        force_unit: found.force_unit.clone(),
        samples: found.samples,
        relative_error: found.relative_error,
        parameters: found.parameters.iter().map(|(name, p)| (name.clone(), quantity(p))).collect(),
        undetermined: found
            .not_identifiable
            .iter()
            .map(|n| Undetermined {
                parameter: n.parameter.clone(),
                because: n.because.clone(),
                experiment: n.experiment.clone(),
            })
            .collect(),
        faults: found.recording_faults.clone(),
        how: vec![found.estimator.clone(), found.preprocess.clone()],
        time: signals.time.clone(),
        velocity: signals.velocity.clone(),
        force: signals.force.clone(),
        predicted: model.predict_signals(signals),
        friction: signals.force.iter().zip(&signals.acceleration).map(|(f, a)| f - mass * a).collect(),
    }
}
