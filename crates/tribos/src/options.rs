//! Options several commands share, and the values they accept.

use clap::ValueEnum;
use procedures::identified::{FittedLaw, Preprocessing};
use procedures::numbers::positive;
pub(crate) use procedures::numbers::{cutoff, noise};
use std::path::PathBuf;

/// Friction law to identify.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum LawChoice {
    /// Asymmetric Coulomb and viscous friction with static levels (modified Karnopp) [thesis, eq. 3.1]
    #[default]
    Karnopp,
    /// Presliding spring into a viscous slide (modified Dahl) [thesis, eq. 3.2, 3.3]
    Dahl,
}

impl From<LawChoice> for FittedLaw {
    fn from(choice: LawChoice) -> Self {
        match choice {
            LawChoice::Karnopp => Self::Karnopp,
            LawChoice::Dahl => Self::Dahl,
        }
    }
}

/// How positions become velocities and accelerations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum PreprocessChoice {
    /// One zero-phase filter on every signal and every regressor
    #[default]
    Tribos,
    /// The filtering and decimation published with the EMPS data
    Emps,
    /// The columns as recorded; what is missing by four-point differences
    Thesis,
}

impl From<PreprocessChoice> for Preprocessing {
    fn from(choice: PreprocessChoice) -> Self {
        match choice {
            PreprocessChoice::Tribos => Self::Tribos,
            PreprocessChoice::Emps => Self::Emps,
            PreprocessChoice::Thesis => Self::Thesis,
        }
    }
}

/// Recordings to read.
#[derive(Debug, Clone, clap::Args)]
pub struct Recordings {
    /// Recordings: text, .mat, .json, .h5, .parquet, .mcap, ROS 2 bags; signals named with their units, or by --map
    #[arg(required = true, value_name = "REC")]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub mapping: Mapping,
}

/// What the variables of a file mean.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Mapping {
    /// Signals from variables of a file, e.g. position_m=qm,force_n=gtau*vir; time of a .mat is `t` unless time_s=… says
    /// otherwise. Files whose columns are named as in a tribos recording need none; for files of several kinds, give one map each.
    /// In a ROS 2 log position, velocity and effort are those of the joint, and force_n=/ft:force.z is a series of another topic
    #[arg(long = "map", value_name = "SIGNAL=VARIABLE,…")]
    pub maps: Vec<String>,
    /// Joint to read, of a file that has several: its name in a ROS 2 log, the label in the names of columns (j2 in
    /// j2_position_rad or position_rad_j2), or the column of an array, from 1
    #[arg(long, value_name = "NAME")]
    pub joint: Option<String>,
}

/// Where results go.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Results {
    /// Write the model found, ready for predict, simulate and the device
    #[arg(long, value_name = "model.toml")]
    pub out: Option<PathBuf>,
    /// Write the result as JSON, `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write a self-contained HTML report
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

impl Results {
    /// Refuses what cannot be written before anything is computed.
    ///
    /// # Errors
    /// The first file that cannot be written.
    pub(crate) fn check(&self) -> crate::failure::Result<()> {
        [&self.out, &self.json, &self.report]
            .into_iter()
            .flatten()
            .try_for_each(|p| crate::files::check_writable(p))
    }

    /// One line for each file that was written.
    pub(crate) fn written(&self) -> String {
        let files = [("model", &self.out), ("json", &self.json), ("report", &self.report)];
        files
            .into_iter()
            .filter_map(|(what, path)| path.as_ref().map(|path| format!("  {what}: {}\n", path.display())))
            .collect()
    }

    /// Standard output belongs to the JSON.
    pub(crate) fn json_on_stdout(&self) -> bool {
        self.json.as_deref() == Some(std::path::Path::new("-"))
    }
}

/// A length of time: finite and above zero.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    positive(text, "seconds", 3600.0)
}

/// A factor: finite and above zero.
pub(crate) fn factor(text: &str) -> Result<f64, String> {
    positive(text, "a factor", 100.0)
}

/// Finite and above zero.
pub(crate) fn above_zero(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(v) if v.is_finite() && v > 0.0 => Ok(v),
        _ => Err("a finite number above 0 is accepted".into()),
    }
}

/// Finite, and may be zero.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(v) if v.is_finite() && v >= 0.0 => Ok(v),
        _ => Err("a finite number from 0 on is accepted".into()),
    }
}
