//! Services for the lab: a line to the device, analyses, conversions.

use crate::commands::{diagnose as diagnosing, experiment as experimenting, identify as identifying};
use crate::failure::{Failure, Result};
use crate::options::Mapping;
use crate::{files, reading};
use client::Session;
use lab::{Found, Progress, Tools};
use perception::study;
use std::path::{Path, PathBuf};

/// The tools, for one port.
pub(crate) struct HostTools {
    port: String,
    seed: u64,
}

impl HostTools {
    pub fn new(port: &str, seed: u64) -> Self {
        Self { port: port.to_owned(), seed }
    }

    /// Checks that the port can be opened.
    ///
    /// # Errors
    /// The reason why not.
    pub fn check(&self) -> Result<()> {
        Session::open(&self.port, self.seed)?;
        Ok(())
    }
}

fn words(failure: Failure) -> String {
    failure.message().to_owned()
}

impl Tools for HostTools {
    fn port(&self) -> &str {
        &self.port
    }

    fn open(&self) -> std::result::Result<Session, client::Error> {
        Session::open(&self.port, self.seed)
    }

    fn identify(
        &self,
        recordings: &[PathBuf],
        report: &Path,
        progress: Progress<'_>,
    ) -> std::result::Result<Found, String> {
        progress(0.1, "fitting");
        let (text, html, model) = identifying::by_defaults(recordings).map_err(words)?;
        files::write(report, html.as_bytes()).map_err(words)?;
        Ok(Found { text, preset: model.preset_lines(), ..Found::default() })
    }

    fn diagnose(
        &self,
        recordings: &[PathBuf],
        report: &Path,
        progress: Progress<'_>,
    ) -> std::result::Result<Found, String> {
        let train = reading::read_all(recordings, &Mapping::default()).map_err(words)?;
        let found = diagnose::diagnose(&train, &[], &diagnose::Options::default(), &|share, what| {
            progress(share, what);
        })
        .map_err(|e| e.to_string())?;
        let name = train.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", ");
        files::write(report, report::diagnosis(&found, &name).as_bytes()).map_err(words)?;
        let preset = found.model.as_ref().map(identify::Model::preset_lines).unwrap_or_default();
        Ok(Found { text: diagnosing::outline(&name, &found), preset, ..Found::default() })
    }

    fn analyse(
        &self,
        sessions: &[PathBuf],
        report: &Path,
        progress: Progress<'_>,
    ) -> std::result::Result<Found, String> {
        progress(0.1, "fitting");
        let sessions = study::read(sessions).map_err(|e| words(e.into()))?;
        let analysis = study::analyse(&sessions, perception::Margins::THESIS);
        let html = report::sessions(&analysis).map_err(|e| e.to_string())?;
        files::write(report, html.as_bytes()).map_err(words)?;
        let stem = report.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut tables = Vec::new();
        for (name, table) in study::tables(&sessions, &analysis) {
            let name = format!("{stem}-{name}");
            files::write(&report.with_file_name(&name), table.as_bytes()).map_err(words)?;
            tables.push(name);
        }
        Ok(Found { text: experimenting::text(&analysis), tables, ..Found::default() })
    }

    fn to_mcap(&self, recording: &Path, out: &Path) -> std::result::Result<(), String> {
        let recording = reading::read(recording, &Mapping::default()).map_err(words)?;
        recording.write(out).map(drop).map_err(|e| e.to_string())
    }
}
