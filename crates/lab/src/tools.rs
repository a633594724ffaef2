//! Functions of the host command that the page offers; the caller implements them.

use client::Session;
use design::LeftOut;
use serde::Serialize;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// What an analysis found.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Found {
    /// As the terminal would show it.
    pub text: String,
    /// Parameters as a preset, ready to be set: name and value.
    pub preset: Vec<(String, String)>,
    /// Tables that were written beside the report, by name.
    pub tables: Vec<String>,
    /// The answer as one sentence.
    pub summary: String,
    /// Parts of the model that are no parameter of a preset.
    pub left_out: Vec<LeftOut>,
}

/// How far an analysis is, 0 to 1, and what it does; `Break` ends it early.
pub type Progress<'a> = &'a dyn Fn(f32, &str) -> ControlFlow<()>;

/// The host command, as the lab uses it.
pub trait Tools: Send + Sync {
    /// The port as the user named it; `sim` is a virtual device, whose handle the page may hold.
    fn port(&self) -> &str;

    /// Opens the device; called again when it was lost.
    ///
    /// # Errors
    /// Why it cannot be opened, and what would help.
    fn open(&self) -> Result<Session, client::Error>;

    /// Identifies friction from recordings, and writes a report.
    ///
    /// # Errors
    /// What is wrong with the recordings.
    fn identify(
        &self,
        recordings: &[PathBuf],
        report: &Path,
        progress: Progress<'_>,
    ) -> Result<Found, String>;

    /// Diagnoses what a simulation leaves out on recordings, and writes a report.
    ///
    /// # Errors
    /// What is wrong with the recordings.
    fn diagnose(
        &self,
        recordings: &[PathBuf],
        report: &Path,
        progress: Progress<'_>,
    ) -> Result<Found, String>;

    /// Analyses sessions of experiments, writes a report, and tidy tables beside it, whose names begin as the report's.
    ///
    /// # Errors
    /// What is wrong with the sessions.
    fn analyse(&self, sessions: &[PathBuf], report: &Path, progress: Progress<'_>) -> Result<Found, String>;

    /// Why this is not a recording of a body on the handle, and must not be rendered; none if it is one.
    ///
    /// # Errors
    /// What is wrong with the recording.
    fn not_a_body(&self, recording: &Path) -> Result<Option<String>, String>;

    /// Writes a recording as MCAP.
    ///
    /// # Errors
    /// What is wrong with the recording, or the file cannot be written.
    fn to_mcap(&self, recording: &Path, out: &Path) -> Result<(), String>;
}
