//! `tribos identify REC…`

use crate::failure::{Failure, Outcome, Result};
use crate::options::{LawChoice, PreprocessChoice, Recordings, Results};
use crate::{files, reading};
use identify::{Estimate, Identification, Model};
use procedures::identified::{How, identify};
use procedures::planar::{self, Recordings as Recorded};
use report::Table;
use report::number::{number, with_std};

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

pub(crate) fn run(args: &Args) -> Result<Outcome> {
    args.results.check()?;
    let how = How {
        law: args.law.into(),
        preprocess: args.preprocess.into(),
        cutoff_hz: args.cutoff,
        delta_v: args.delta_v,
        least_squares: args.least_squares,
    };
    how.check()?;
    let recordings = match reading::read_any(&args.recordings.files, &args.recordings.mapping)? {
        Recorded::Line(recordings) => recordings,
        Recorded::Plane(recordings) => return in_the_plane(args, &how, &recordings),
    };
    if let Some(name) = &args.expect {
        check_parameter(how.law.parameters(), name)?;
    }
    let main = identify(&recordings, &how)?;
    if let Some(path) = &args.results.out {
        let text = main.model.to_toml();
        files::write(path, text.as_bytes())?;
    }
    if let Some(path) = &args.results.report {
        files::write(path, main.report().as_bytes())?;
    }
    if let Some(path) = &args.results.json {
        let text = main.found.to_json().map_err(Failure::new)?;
        files::write(path, format!("{text}\n").as_bytes())?;
    }
    if !args.results.json_on_stdout() {
        print!("{}", describe(&main.name, &main.found, main.beside.as_ref()));
        print!("{}", args.results.written());
    }
    Ok(match &args.expect {
        Some(name) if !main.found.parameters.contains_key(name) => Outcome::ExpectedFindingAbsent,
        _ => Outcome::Done,
    })
}

/// Parameters that an identification in the plane may have.
const PLANAR: [&str; 14] = [
    "mass",
    "mass_x",
    "mass_y",
    "level",
    "level_along",
    "level_across",
    "angle",
    "viscous",
    "viscous_xx",
    "viscous_xy",
    "viscous_yy",
    "offset_x",
    "offset_y",
    "friction_lag",
];

fn in_the_plane(args: &Args, how: &How, recordings: &[signals::PlanarRecording]) -> Result<Outcome> {
    if let Some(name) = &args.expect {
        check_parameter(&PLANAR, name)?;
    }
    let main = planar::identify(recordings, how)?;
    let found = &main.planar.found;
    if let Some(path) = &args.results.out {
        files::write(path, main.planar.model.to_toml().as_bytes())?;
    }
    if let Some(path) = &args.results.report {
        files::write(path, main.report().as_bytes())?;
    }
    if let Some(path) = &args.results.json {
        let text = found.to_json().map_err(Failure::new)?;
        files::write(path, format!("{text}\n").as_bytes())?;
    }
    if !args.results.json_on_stdout() {
        print!("{}", describe(&main.name, found, None));
        print!("{}", args.results.written());
    }
    Ok(match &args.expect {
        Some(name) if !found.parameters.contains_key(name) => Outcome::ExpectedFindingAbsent,
        _ => Outcome::Done,
    })
}

/// Identifies by the defaults: the result as people read it, the report, and the model.
///
/// # Errors
/// What is wrong with the recordings.
pub(crate) fn by_defaults(files: &[std::path::PathBuf]) -> Result<(String, String, Model)> {
    let recordings = reading::read_all(files, &crate::options::Mapping::default())?;
    let fit = identify(&recordings, &How::default())?;
    Ok((describe(&fit.name, &fit.found, None), fit.report(), fit.model))
}

/// A parameter the law has.
fn check_parameter(known: &[&str], name: &str) -> Result<()> {
    if known.contains(&name) {
        return Ok(());
    }
    Err(Failure::new(format!("--expect: the law has no parameter `{name}`"))
        .help(format!("accepted are {}", known.join(", "))))
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
const ORDER: [&str; 21] = [
    "mass",
    "mass_x",
    "mass_y",
    "level",
    "level_along",
    "level_across",
    "angle",
    "coulomb_p",
    "coulomb_n",
    "viscous_p",
    "viscous_n",
    "coulomb",
    "viscous",
    "viscous_xx",
    friction::parameters::OFFSET.name,
    friction::parameters::DELAY.name,
    "static_p",
    "static_n",
    "delta_v",
    "limit_p",
    "limit_n",
];
