//! Joint evaluation of the sessions of the perception experiments.

mod claims;
mod tidy;

pub use claims::{Claim, HARD, Shown};
pub use tidy::tables;

use crate::{
    Counts, Difference, Experiment, Fit, LogError, Margins, Record, Resistance, RingCase, Session,
    Throughput, counts, differences, levels, segments, throughput,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Sessions that cannot be analysed together.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file is no session.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A folder cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A folder without a session.
    #[error("{}: no session in this folder", .0.display())]
    NoSession(PathBuf),
    /// A subject did the targeting task twice.
    #[error("{}: subject `{subject}` did the targeting task in {} already", path.display(), other.display())]
    Twice {
        /// The second session.
        path: PathBuf,
        /// Who.
        subject: String,
        /// The first session.
        other: PathBuf,
    },
    /// Sessions of people beside sessions of simulated subjects.
    #[error("{}: people and simulated subjects are not analysed together", .0.display())]
    Mixed(PathBuf),
}

impl Error {
    /// What would be accepted.
    #[must_use]
    pub fn help(&self) -> Option<&'static str> {
        match self {
            Self::NoSession(_) => Some("files ending in .jsonl are read"),
            Self::Twice { .. } => Some("one targeting session a subject is accepted"),
            Self::Mixed(_) => Some("give the sessions of one kind"),
            Self::Log(_) | Self::Folder { .. } => None,
        }
    }
}

/// Name of all subjects together.
pub const POOLED: &str = "all";

/// Throughput of one segment, and whose it is.
#[derive(Debug, Clone, Serialize)]
pub struct Speed {
    /// Who.
    pub subject: String,
    /// Under which resistance.
    pub resistance: Resistance,
    /// Index of difficulty as in [thesis, table 5-1].
    pub index: u32,
    /// The throughput.
    #[serde(flatten)]
    pub throughput: Throughput,
}

/// A circle of targets in the plane, and whose it is.
#[derive(Debug, Clone, Serialize)]
pub struct RingSpeed {
    /// Who.
    pub subject: String,
    /// Number of the circle from 1.
    pub trial: usize,
    /// Circle and surface.
    #[serde(flatten)]
    pub case: RingCase,
    /// Index of difficulty, bits.
    pub id_bits: f64,
    /// Number of selections that missed.
    pub errors: usize,
    /// The throughput.
    #[serde(flatten)]
    pub throughput: Throughput,
}

/// A psychometric function, and whose it is.
#[derive(Debug, Clone, Serialize)]
pub struct Fitted {
    /// Who, or [`POOLED`].
    pub subject: String,
    /// Batch of the forced choice.
    pub batch: String,
    /// The function.
    #[serde(flatten)]
    pub fit: Fit,
}

/// The analysis.
#[derive(Debug, Clone, Serialize)]
pub struct Analysis {
    /// Version of the layout.
    pub schema: &'static str,
    /// Every subject is a model: no human data.
    pub simulated: bool,
    /// What the models are, each once.
    pub models: Vec<String>,
    /// Everybody, each once.
    pub subjects: Vec<String>,
    /// From where on a difference counts.
    pub margins: Margins,
    /// Reported results, checked on these sessions.
    pub claims: Vec<Claim>,
    /// Who was better or worse than in the baseline.
    pub counts: Vec<Counts>,
    /// Each subject against its own baseline.
    pub differences: Vec<Difference>,
    /// Of every segment.
    pub throughput: Vec<Speed>,
    /// Of every circle in the plane.
    pub rings: Vec<RingSpeed>,
    /// Of each subject and of all together.
    pub psychometric: Vec<Fitted>,
    /// What a reader must know.
    pub notes: Vec<String>,
}

impl Analysis {
    /// The end of "subject".
    #[must_use]
    pub fn plural(&self) -> &'static str {
        if self.subjects.len() == 1 { "" } else { "s" }
    }
}

/// Reads sessions from files, and from every `.jsonl` in folders.
///
/// # Errors
/// A file that is no session; a folder without one; subjects twice; people and models together.
pub fn read(paths: &[PathBuf]) -> Result<Vec<Session>, Error> {
    let mut found = Vec::new();
    for path in paths {
        if !path.is_dir() {
            found.push(path.clone());
            continue;
        }
        let entries =
            std::fs::read_dir(path).map_err(|source| Error::Folder { path: path.clone(), source })?;
        let mut inside: Vec<PathBuf> = entries
            .flatten()
            .map(|e| e.path())
            .filter(|p| p.extension().is_some_and(|e| e == "jsonl"))
            .collect();
        inside.sort();
        if inside.is_empty() {
            return Err(Error::NoSession(path.clone()));
        }
        found.extend(inside);
    }
    let mut sessions: Vec<Session> = Vec::new();
    let mut seen: BTreeMap<String, &Path> = BTreeMap::new();
    for path in &found {
        let session = Session::read(path)?;
        let subject = &session.header.subject;
        if matches!(session.header.experiment, Experiment::Targeting(_))
            && let Some(other) = seen.insert(subject.id.clone(), path)
        {
            return Err(Error::Twice {
                path: path.clone(),
                subject: subject.id.clone(),
                other: other.to_owned(),
            });
        }
        let simulated = subject.simulated.is_some();
        if sessions.iter().any(|other| other.header.subject.simulated.is_some() != simulated) {
            return Err(Error::Mixed(path.clone()));
        }
        sessions.push(session);
    }
    Ok(sessions)
}

/// Analyses them.
#[must_use]
pub fn analyse(sessions: &[Session], margins: Margins) -> Analysis {
    let scored = segments(sessions);
    let differences = differences(&scored);
    let mut subjects: Vec<String> = sessions.iter().map(|s| s.header.subject.id.clone()).collect();
    subjects.sort();
    subjects.dedup();
    let mut models: Vec<String> = sessions
        .iter()
        .filter_map(|s| s.header.subject.simulated.as_ref())
        .map(|s| s.model.clone())
        .collect();
    models.sort();
    models.dedup();
    let speeds = scored.iter().filter_map(|s| {
        Some(Speed {
            subject: s.subject.to_owned(),
            resistance: s.trial.resistance,
            index: s.trial.difficulty.index,
            throughput: throughput(s.trial)?,
        })
    });
    let mut notes = Vec::new();
    for s in sessions.iter().filter(|s| s.cut_off) {
        notes.push(format!("{}: a last line was cut off and is left out", s.header.subject.id));
    }
    Analysis {
        schema: "tribos.experiment/1",
        simulated: !models.is_empty(),
        models,
        subjects,
        margins,
        claims: claims::claims(&differences),
        counts: counts(&differences, &margins),
        throughput: speeds.collect(),
        rings: rings(sessions),
        psychometric: psychometric(sessions),
        differences,
        notes,
    }
}

/// Every circle that has a throughput.
fn rings(sessions: &[Session]) -> Vec<RingSpeed> {
    let mut all = Vec::new();
    for session in sessions {
        for record in &session.records {
            let Record::Ring(trial) = record else { continue };
            all.extend(trial.throughput().map(|throughput| RingSpeed {
                subject: session.header.subject.id.clone(),
                trial: trial.number,
                case: trial.case.clone(),
                id_bits: trial.id_bits,
                errors: trial.errors,
                throughput,
            }));
        }
    }
    all
}

/// Surfaces of the circles, each with the mean throughput in bit/s and effective width in mm.
#[must_use]
pub fn surfaces(analysis: &Analysis) -> Vec<(&str, f64, f64)> {
    let mut names: Vec<&str> = analysis.rings.iter().map(|r| r.case.surface.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let mean = |name: &str, value: &dyn Fn(&Throughput) -> f64| {
        let of: Vec<f64> =
            analysis.rings.iter().filter(|r| r.case.surface == name).map(|r| value(&r.throughput)).collect();
        of.iter().sum::<f64>() / of.len() as f64
    };
    let row = |name| (name, mean(name, &|t| t.bits_per_s), mean(name, &|t| t.effective_width_mm));
    names.into_iter().map(row).collect()
}

/// Of each subject and of all together, batch by batch.
fn psychometric(sessions: &[Session]) -> Vec<Fitted> {
    let mut answers: BTreeMap<(String, String), Vec<(f64, bool)>> = BTreeMap::new();
    let mut batches: Vec<String> = Vec::new();
    for session in sessions {
        for record in &session.records {
            let Record::ForcedChoice(trial) = record else { continue };
            if !batches.contains(&trial.batch) {
                batches.push(trial.batch.clone());
            }
            for subject in [session.header.subject.id.as_str(), POOLED] {
                let key = (trial.batch.clone(), subject.to_owned());
                answers.entry(key).or_default().push((trial.difference_n, trial.correct));
            }
        }
    }
    let fitted = answers.into_iter().filter_map(|((batch, subject), answers)| {
        Some(Fitted { subject, batch, fit: Fit::new(&levels(answers))? })
    });
    let mut fitted: Vec<Fitted> = fitted.collect();
    let place = |f: &Fitted| batches.iter().position(|b| *b == f.batch);
    // all together first
    fitted.sort_by_key(|f| (place(f), f.subject != POOLED, f.subject.clone()));
    fitted
}

/// Mean throughput in bit/s and effective width in mm under a resistance.
#[must_use]
pub fn mean_throughput(analysis: &Analysis, resistance: Resistance) -> Option<(f64, f64)> {
    let of: Vec<_> = analysis.throughput.iter().filter(|s| s.resistance == resistance).collect();
    let n = of.len() as f64;
    let mean = |value: &dyn Fn(&Throughput) -> f64| of.iter().map(|s| value(&s.throughput)).sum::<f64>() / n;
    (!of.is_empty()).then(|| (mean(&|t| t.bits_per_s), mean(&|t| t.effective_width_mm)))
}
