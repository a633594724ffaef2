//! What can end a proof.

use signals::files::FileError;
use std::path::{Path, PathBuf};

/// What every step of a proof returns.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// A proof that cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A folder cannot be made.
    #[error("{}: cannot be made: {reason}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// Of the operating system.
        reason: String,
    },
    /// The folder holds a proof of another extent.
    #[error("{}: holds another proof", .0.display())]
    OtherProof(PathBuf),
    /// A file of the proof is missing or damaged.
    #[error("{}: {why}", path.display())]
    Damaged {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// A recording cannot be read or written; names it.
    #[error(transparent)]
    Recording(#[from] signals::Error),
    /// The diagnosis refuses a recording.
    #[error(transparent)]
    Diagnosis(#[from] diagnose::Error),
    /// A result that is not JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

impl Error {
    /// A file of the proof that is missing or damaged.
    pub(crate) fn damaged(path: &Path, why: impl std::fmt::Display) -> Self {
        Self::Damaged { path: path.to_owned(), why: why.to_string() }
    }

    /// What to do about it.
    #[must_use]
    pub fn help(&self) -> Option<&'static str> {
        match self {
            Self::OtherProof(_) => Some("the same options continue it; another --out begins a new one"),
            _ => None,
        }
    }
}
