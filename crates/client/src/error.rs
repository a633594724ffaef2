//! Errors between host and device.

use signals::files::FileError;
use std::path::PathBuf;

/// Result of an operation on a device.
pub type Result<T> = std::result::Result<T, Error>;

/// A failed operation on a device. The message is one line; [`Error::help`] gives the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The port cannot be opened.
    #[error("port {port}: cannot be opened: {reason}")]
    Port {
        /// Port as named by the user.
        port: String,
        /// Reason of the operating system.
        reason: String,
        /// Existing ports.
        available: Vec<String>,
    },
    /// The line failed during use.
    #[error("port {port}: the line is gone: {reason}")]
    Gone {
        /// Port as named by the user.
        port: String,
        /// Reason of the operating system.
        reason: String,
    },
    /// The virtual device cannot be built.
    #[error("{0}")]
    Virtual(String),
    /// The device refused a command.
    #[error("{port}: `{command}` was refused: {answer}")]
    Refused {
        /// Port as named by the user.
        port: String,
        /// Sent command.
        command: String,
        /// Answer of the device, `err CODE: why`.
        answer: String,
    },
    /// The device does not know the middle of its stroke, and may not search it.
    #[error("{port}: the device does not know the middle of its stroke since it started")]
    Unreferenced {
        /// Port as named by the user.
        port: String,
    },
    /// The search for the stops failed.
    #[error("{port}: {why}")]
    NotHomed {
        /// Port as named by the user.
        port: String,
        /// Line of the device.
        why: String,
    },
    /// No answer came.
    #[error("{port}: no answer to `{command}` within {seconds} s")]
    NoAnswer {
        /// Port as named by the user.
        port: String,
        /// Sent command.
        command: String,
        /// Time waited for the answer.
        seconds: u64,
    },
    /// The stream stopped.
    #[error("{port}: no frames for {seconds} s")]
    Silent {
        /// Port as named by the user.
        port: String,
        /// Time without data.
        seconds: u64,
    },
    /// The device stopped on a fault during the recording.
    #[error("{port}: stopped by the fault {fault}")]
    Fault {
        /// Port as named by the user.
        port: String,
        /// Description of the fault.
        fault: String,
    },
    /// The recording was interrupted before its first sample.
    #[error("{}: interrupted before the first sample; nothing was written", .0.display())]
    Interrupted(PathBuf),
    /// No live stream to this address.
    #[error("live {address}: {why}")]
    Live {
        /// Address as named by the user.
        address: String,
        /// What is wrong, and what would be accepted.
        why: String,
    },
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A recording failed after its first samples, which are kept.
    #[error("{error}")]
    Partial {
        /// Reason.
        error: Box<Error>,
        /// File with the samples recorded so far.
        part: PathBuf,
    },
}

impl Error {
    /// Remedy, in one line.
    #[must_use]
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Port { available, .. } if available.is_empty() => Some(
                "no serial port was found; `sim` is the virtual device, or start one with `cargo run --release`"
                    .to_owned(),
            ),
            Self::Port { available, .. } => {
                Some(format!("ports found: {}; `sim` is the virtual device", available.join(", ")))
            }
            Self::NoAnswer { .. } => {
                Some("is it a tribos device, and does nobody else hold its line?".to_owned())
            }
            Self::Silent { .. } => {
                Some("is the device still connected? its `status` says what it does".to_owned())
            }
            Self::Unreferenced { port } => Some(format!(
                "type `home`, or move the handle to the middle and type `zero`, in `tribos connect {port}`"
            )),
            Self::Fault { .. } => Some(
                "`fault` tells more, `clear` clears it; a smaller move asks less of the device".to_owned(),
            ),
            Self::Partial { part, .. } => {
                Some(format!("what was recorded until then is in {}", part.display()))
            }
            Self::Gone { .. }
            | Self::Virtual(_)
            | Self::Refused { .. }
            | Self::NotHomed { .. }
            | Self::Interrupted(_)
            | Self::Live { .. }
            | Self::File(_) => None,
        }
    }

    /// Whether the device refused the command or stopped on a fault. Another command may work.
    #[must_use]
    pub fn is_declined(&self) -> bool {
        match self {
            Self::Refused { .. } | Self::Fault { .. } => true,
            Self::Partial { error, .. } => error.is_declined(),
            _ => false,
        }
    }
}
