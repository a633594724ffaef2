//! What sessions of the perception experiments say together.

mod claims;
mod figures;
mod report;
mod tidy;

pub(crate) use claims::{Claim, Shown};
pub(crate) use figures::{psychometric_curves, quadrants};
pub(crate) use report::{html, mean_throughput, threshold_text};
pub(crate) use tidy::tables;

use crate::failure::{Failure, Result};
use crate::files;
use perception::{
    Counts, Difference, Experiment, Fit, LogError, Margins, Record, Resistance, Session, Throughput, counts,
    differences, levels, segments, throughput,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Name of all subjects together.
pub(crate) const POOLED: &str = "all";

/// Throughput of one segment, and whose it is.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Speed {
    pub subject: String,
    pub resistance: Resistance,
    pub index: u32,
    #[serde(flatten)]
    pub throughput: Throughput,
}

/// A psychometric function, and whose it is.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Fitted {
    pub subject: String,
    pub batch: String,
    #[serde(flatten)]
    pub fit: Fit,
}

/// The analysis.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Analysis {
    pub schema: &'static str,
    /// Every subject is a model: no human data.
    pub simulated: bool,
    /// What the models are, each once.
    pub models: Vec<String>,
    pub subjects: Vec<String>,
    pub margins: Margins,
    pub claims: Vec<Claim>,
    pub counts: Vec<Counts>,
    pub differences: Vec<Difference>,
    pub throughput: Vec<Speed>,
    pub psychometric: Vec<Fitted>,
    /// What a reader must know.
    pub notes: Vec<String>,
}

impl Analysis {
    /// The end of "subject".
    pub(crate) fn plural(&self) -> &'static str {
        if self.subjects.len() == 1 { "" } else { "s" }
    }
}

/// Reads sessions from files, and from every `.jsonl` in folders.
///
/// # Errors
/// A file that is no session; a folder without one; subjects twice; people and models together.
pub(crate) fn read(paths: &[PathBuf]) -> Result<Vec<Session>> {
    let mut found = Vec::new();
    for path in paths {
        if !path.is_dir() {
            found.push(path.clone());
            continue;
        }
        let entries = std::fs::read_dir(path)
            .map_err(|e| Failure::in_file(path, format!("cannot be read: {}", files::reason(&e))))?;
        let mut inside: Vec<PathBuf> = entries
            .flatten()
            .map(|e| e.path())
            .filter(|p| p.extension().is_some_and(|e| e == "jsonl"))
            .collect();
        inside.sort();
        if inside.is_empty() {
            return Err(
                Failure::in_file(path, "no session in this folder").help("files ending in .jsonl are read")
            );
        }
        found.extend(inside);
    }
    let mut sessions: Vec<Session> = Vec::new();
    let mut seen: BTreeMap<String, &Path> = BTreeMap::new();
    for path in &found {
        let session = Session::read(path).map_err(|e| match e {
            LogError::Io { path, source } => Failure::in_file(&path, files::reason(&source)),
            other @ LogError::Line { .. } => Failure::new(other),
        })?;
        let subject = &session.header.subject;
        if matches!(session.header.experiment, Experiment::Targeting(_))
            && let Some(other) = seen.insert(subject.id.clone(), path)
        {
            return Err(Failure::in_file(
                path,
                format!("subject `{}` did the targeting task in {} already", subject.id, other.display()),
            )
            .help("one targeting session a subject is accepted"));
        }
        let simulated = subject.simulated.is_some();
        if sessions.iter().any(|other| other.header.subject.simulated.is_some() != simulated) {
            return Err(Failure::in_file(path, "people and simulated subjects are not analysed together")
                .help("give the sessions of one kind"));
        }
        sessions.push(session);
    }
    Ok(sessions)
}

/// Analyses them.
pub(crate) fn analyse(sessions: &[Session], margins: Margins) -> Analysis {
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
        psychometric: psychometric(sessions),
        differences,
        notes,
    }
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
