//! What can end a procedure.

use std::path::{Path, PathBuf};

/// What a procedure returns.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// A procedure that cannot go on. The message is one line; [`Error::help`] says what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The device, or its line.
    #[cfg(feature = "device")]
    #[error(transparent)]
    Device(#[from] client::Error),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] signals::files::FileError),
    /// A folder cannot be made.
    #[error("{}: cannot be made a folder: {reason}", path.display())]
    Folder {
        /// Which.
        path: PathBuf,
        /// Of the operating system.
        reason: String,
    },
    /// A recording or a model cannot be read or used.
    #[error(transparent)]
    Recording(#[from] signals::Error),
    /// Neither a file nor a preset of the library.
    #[error("{error}")]
    NoPreset {
        /// Why it is no file.
        error: signals::Error,
    },
    /// Recordings cannot be diagnosed.
    #[error(transparent)]
    Diagnosis(#[from] diagnose::Error),
    /// Recordings cannot be compared.
    #[error(transparent)]
    Comparison(#[from] compare::Error),
    /// A picture cannot be drawn.
    #[error(transparent)]
    Draw(#[from] report::picture::DrawError),
    /// An option outside what is accepted.
    #[error("{option}: {why}")]
    Option {
        /// Its name, words joined by `_`.
        option: &'static str,
        /// The value, and what would be accepted.
        why: String,
        /// What to do about it.
        help: Option<String>,
    },
    /// Recordings that cannot be used together, or none.
    #[error("{why}")]
    Input {
        /// Which, and why.
        why: String,
        /// What to do about it.
        help: Option<String>,
    },
    /// The virtual device refuses the block.
    #[error("{0}")]
    Block(String),
    /// The device refuses a parameter of an identified model.
    #[error("the device refuses what was identified: {0}")]
    Identified(String),
    /// The simulated rig refuses a model or a move.
    #[error("the simulated rig refuses: {0}")]
    Rig(String),
    /// A fault ended the simulation.
    #[error("the simulated rig stopped after {seconds:.3} s: {fault}")]
    Stopped {
        /// Time of the simulation, s.
        seconds: f64,
        /// The fault in words.
        fault: String,
    },
    /// A model gave a force that is no number.
    #[error("the model gave a force that is not a number")]
    NotFinite,
    /// No move is left to make.
    #[error("no move to make")]
    NoMove,
    /// Interrupted, and nothing is kept.
    #[error("interrupted")]
    Cancelled,
    /// Interrupted before anything was diagnosed.
    #[error("interrupted before the first recording was complete: nothing was diagnosed")]
    Interrupted,
}

impl Error {
    pub(crate) fn option(option: &'static str, why: impl Into<String>) -> Self {
        Self::Option { option, why: why.into(), help: None }
    }

    pub(crate) fn input(why: impl Into<String>) -> Self {
        Self::Input { why: why.into(), help: None }
    }

    /// A failure about a file: `FILE: why`, unless `why` already begins with the file's name.
    pub(crate) fn in_file(path: &Path, why: &dyn std::fmt::Display) -> Self {
        let (path, why) = (path.display().to_string(), why.to_string());
        Self::input(if why.starts_with(&path) { why } else { format!("{path}: {why}") })
    }

    pub(crate) fn with_help(mut self, text: impl Into<String>) -> Self {
        if let Self::Option { help, .. } | Self::Input { help, .. } = &mut self {
            *help = Some(text.into());
        }
        self
    }

    /// What to do about it, in one line.
    #[must_use]
    pub fn help(&self) -> Option<String> {
        match self {
            #[cfg(feature = "device")]
            Self::Device(error) => error.help(),
            Self::Option { help, .. } | Self::Input { help, .. } => help.clone(),
            Self::Comparison(error) => error.help().map(str::to_owned),
            Self::NoPreset { .. } => Some("`tribos preset list` has the names of the library".to_owned()),
            Self::Stopped { .. } => {
                Some("a smaller amplitude or a lower frequency asks less of it".to_owned())
            }
            _ => None,
        }
    }
}
