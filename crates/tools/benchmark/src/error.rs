//! Why a benchmark could not be run.

/// One line that names the file or folder and what is expected there.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The folder has no recording of the benchmark.
    #[error("{dir}: no {file}")]
    Missing {
        /// Folder that was searched.
        dir: String,
        /// File, with its alternatives.
        file: &'static str,
        /// Where the file comes from.
        from: &'static str,
    },
    /// The recording is not the one of the benchmark.
    #[error("{file}: {why}")]
    Wrong {
        /// File.
        file: String,
        /// What was found and what is expected.
        why: String,
    },
    /// The file cannot be read.
    #[error(transparent)]
    Unreadable(#[from] signals::Error),
    /// No model could be fitted.
    #[error("{file}: {why}")]
    Unfit {
        /// File.
        file: String,
        /// What the recording does not determine.
        why: String,
    },
}

impl Error {
    /// What to do instead.
    #[must_use]
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Missing { from, .. } => {
                Some(format!("--data is the folder of the official files; they come from {from}"))
            }
            _ => None,
        }
    }
}
