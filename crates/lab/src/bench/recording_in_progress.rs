//! A recording in progress: its file, and the move that it waits for.

use crate::handover::Bins;
use client::{Header, Plan, RecordingFile};
use std::path::Path;

/// A recording in progress.
pub(super) struct Recording {
    pub(super) name: String,
    pub(super) file: RecordingFile,
    pub(super) samples: u64,
    pub(super) lost: u64,
    /// Time of the first sample, s.
    pub(super) from: Option<f64>,
    pub(super) to: f64,
    pub(super) motion: Option<Motion>,
    /// Length after which it ends by itself, s.
    pub(super) length: Option<f64>,
    /// Force on the load cell.
    pub(super) bins: Bins,
}

/// Move that the recording waits for.
pub(super) struct Motion {
    /// Length wanted, s.
    pub(super) seconds: f64,
    pub(super) identify: bool,
    /// Time the handle was driven from, s.
    pub(super) driven: Option<f64>,
}

impl Recording {
    /// Waits for a move of `seconds` and ends with it.
    pub fn of_a_move(&mut self, seconds: f64, identify: bool) {
        self.motion = Some(Motion { seconds, identify, driven: None });
    }

    /// Ends with what there is: the move will not come, or not last.
    pub fn stop_waiting(&mut self) {
        self.motion = None;
    }

    /// Counts lost samples.
    pub fn lost(&mut self, count: u64) {
        if self.from.is_some() {
            self.lost += count;
        }
    }

    /// Removes the file.
    pub fn abandon(self) {
        self.file.discard();
    }
}

/// Begins a file of this stream.
///
/// # Errors
/// The file cannot be written.
pub(super) fn begin_file(
    path: &Path,
    header: &Header,
    notes: Vec<(String, String)>,
) -> Result<RecordingFile, String> {
    // the header says which preset was active when the stream began; the notes say which one is now
    RecordingFile::create(path, header, &Plan { motion: None, seconds: 0.0, notes })
        .map_err(|e| e.to_string())
}
