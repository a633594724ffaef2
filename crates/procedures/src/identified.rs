//! Friction identified from recordings: the fit, its model and its report.

use crate::error::{Error, Result};
use crate::recordings::{joined, model_name};
use crate::watch::{Unwatched, Watch};
use diagnose::Quantity;
use identify::{
    DahlOptions, Errors, Estimate, Identification, KarnoppOptions, Model, Preprocess, Signals,
    identify_dahl_watched, identify_karnopp, prepare,
};
use report::Undetermined;
use signals::{Preparation, Recording};

/// A law that can be identified.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FittedLaw {
    /// Modified Karnopp [thesis, eq. 3.1].
    #[default]
    Karnopp,
    /// Modified Dahl [thesis, eq. 3.2, 3.3].
    Dahl,
}

impl FittedLaw {
    /// Every one.
    pub const ALL: [Self; 2] = [Self::Karnopp, Self::Dahl];

    /// Its id in files and options.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Karnopp => "karnopp",
            Self::Dahl => "dahl",
        }
    }

    /// Parameters that an identification may have.
    #[must_use]
    pub const fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::Karnopp => &[
                "mass",
                "coulomb_p",
                "coulomb_n",
                "viscous_p",
                "viscous_n",
                "static_p",
                "static_n",
                "delta_v",
            ],
            Self::Dahl => &["mass", "viscous", "limit_p", "limit_n", "sigma"],
        }
    }
}

impl std::str::FromStr for FittedLaw {
    type Err = Error;

    fn from_str(id: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|law| law.id() == id).ok_or_else(|| {
            let accepted: Vec<&str> = Self::ALL.iter().map(|law| law.id()).collect();
            Error::option("law", format!("`{id}`: accepted are {}", accepted.join(", ")))
        })
    }
}

/// How positions become velocities and accelerations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Preprocessing {
    /// One zero-phase filter on every signal and every regressor.
    #[default]
    Tribos,
    /// The filtering and decimation published with the EMPS data.
    Emps,
    /// The columns as recorded; what is missing by four-point differences.
    Thesis,
}

impl Preprocessing {
    /// Every one.
    pub const ALL: [Self; 3] = [Self::Tribos, Self::Emps, Self::Thesis];

    /// Its id in options.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Tribos => "tribos",
            Self::Emps => "emps",
            Self::Thesis => "thesis",
        }
    }
}

impl std::str::FromStr for Preprocessing {
    type Err = Error;

    fn from_str(id: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|how| how.id() == id).ok_or_else(|| {
            let accepted: Vec<&str> = Self::ALL.iter().map(|how| how.id()).collect();
            Error::option("preprocess", format!("`{id}`: accepted are {}", accepted.join(", ")))
        })
    }
}

/// How to identify; the default is right for most recordings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct How {
    /// Friction law.
    pub law: FittedLaw,
    /// How velocity and acceleration are derived.
    pub preprocess: Preprocessing,
    /// Cut-off of the filter of [`Preprocessing::Tribos`], Hz; chosen from the noise when not given.
    pub cutoff_hz: Option<f64>,
    /// Δv: slower samples are excluded, m/s (rad/s); chosen from the data when not given.
    pub delta_v: Option<f64>,
    /// Plain least squares [thesis, eq. 3.8] instead of Fuller's estimator [thesis, eq. 3.9].
    pub least_squares: bool,
}

impl How {
    /// Refuses options that do not go together.
    ///
    /// # Errors
    /// The option, and with what it would be accepted.
    pub fn check(&self) -> Result<()> {
        if self.law == FittedLaw::Dahl && self.delta_v.is_some() {
            return Err(Error::option("delta_v", "the law of Dahl has none; accepted with law karnopp"));
        }
        match self.delta_v {
            Some(v) if !(v.is_finite() && v >= 0.0) => {
                Err(Error::option("delta_v", format!("{v}: a finite number from 0 on is accepted")))
            }
            _ => Ok(()),
        }
    }
}

/// What was identified, and what it was made of.
#[derive(Debug, Clone)]
pub struct Identified {
    /// Names of the recordings.
    pub name: String,
    /// What was fitted.
    pub signals: Signals,
    /// The result.
    pub found: Identification,
    /// The same by tribos's own preprocessing, where another was asked for.
    pub beside: Option<Identification>,
    /// The model: `model.toml`, a preset.
    pub model: Model,
}

/// Identifies the friction of recordings as one set of parameters.
///
/// # Errors
/// What is wrong with the recordings or the options.
pub fn identify(recordings: &[Recording], how: &How) -> Result<Identified> {
    identify_watched(recordings, how, &Unwatched)
}

/// As [`identify()`]. Ends early when `watch` is interrupted: between preparation and fit, and within a fit of Dahl's law.
///
/// # Errors
/// As [`identify()`]; [`Error::Cancelled`].
pub fn identify_watched(recordings: &[Recording], how: &How, watch: &dyn Watch) -> Result<Identified> {
    how.check()?;
    let (recording, preparations) = joined(recordings)?;
    let default = How { preprocess: Preprocessing::Tribos, ..*how };
    let (signals, found) = fit(how, &recording, &preparations, watch)?;
    // what a published or a given preprocessing changes is seen beside the default
    let beside = if default == *how {
        None
    } else {
        fit(&default, &recording, &preparations, watch).ok().map(|(_, f)| f)
    };
    go_on(watch)?;
    let model = Model { name: model_name(recordings), ..Model::from(&found) };
    Ok(Identified { name: recording.name, signals, found, beside, model })
}

fn go_on(watch: &dyn Watch) -> Result<()> {
    if watch.is_interrupted() { Err(Error::Cancelled) } else { Ok(()) }
}

fn fit(
    how: &How,
    recording: &Recording,
    preparations: &[Preparation],
    watch: &dyn Watch,
) -> Result<(Signals, Identification)> {
    go_on(watch)?;
    let errors = if how.least_squares { Errors::LeastSquares } else { Errors::default() };
    let preprocess = match how.preprocess {
        Preprocessing::Tribos => Preprocess::Tribos { cutoff_hz: how.cutoff_hz },
        Preprocessing::Emps => Preprocess::Emps,
        Preprocessing::Thesis => Preprocess::Thesis,
    };
    let signals = prepare(recording, &preprocess)?;
    go_on(watch)?;
    let mut found = match how.law {
        FittedLaw::Karnopp => identify_karnopp(
            &signals,
            &KarnoppOptions { errors, delta_v: how.delta_v, ..KarnoppOptions::default() },
        )?,
        FittedLaw::Dahl => {
            let options = DahlOptions { errors, ..DahlOptions::default() };
            identify_dahl_watched(&signals, &options, &|| watch.is_interrupted())?.ok_or(Error::Cancelled)?
        }
    };
    if let [_, _, ..] = preparations {
        // several were joined: each has its own preparation, behind the cut-off of the fit
        let cutoff_hz = signals.preparation().cutoff_hz;
        found.preparation = preparations.iter().map(|p| Preparation { cutoff_hz, ..p.clone() }).collect();
        let of_fit = found.recording_faults.split_off(signals.preparation().faults.len());
        found.recording_faults = preparations.iter().flat_map(|p| p.faults.clone()).chain(of_fit).collect();
    }
    Ok((signals, found))
}

impl Identified {
    /// Series for pictures.
    #[must_use]
    pub fn shown(&self) -> report::Identified {
        let (signals, found) = (&self.signals, &self.found);
        let quantity = |p: &Estimate| Quantity { value: p.value, std: p.std, unit: p.unit.clone() };
        let mass = found.value("mass").unwrap_or(0.0);
        report::Identified {
            name: self.name.clone(),
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
            predicted: self.model.predict_signals(signals),
            friction: signals.force.iter().zip(&signals.acceleration).map(|(f, a)| f - mass * a).collect(),
        }
    }

    /// The report, one self-contained HTML page.
    #[must_use]
    pub fn report(&self) -> String {
        report::identification(&self.shown())
    }
}
