//! Failures as exceptions, in the words of the command.

use pyo3::exceptions::PyValueError;
use pyo3::{PyErr, create_exception};

create_exception!(tribos, TribosError, PyValueError, "What tribos refuses, and what it would accept.");
create_exception!(tribos, RecordingError, TribosError, "A recording that cannot be read or used.");
create_exception!(tribos, ModelError, TribosError, "A model that cannot be read or used.");

/// Message and, on a second line, what to do about it.
fn words(message: &str, help: Option<String>) -> String {
    match help {
        Some(help) => format!("{message}\n  help: {help}"),
        None => message.to_owned(),
    }
}

/// An option that is refused.
pub(crate) fn option(name: &str, why: impl std::fmt::Display) -> PyErr {
    TribosError::new_err(format!("{name}: {why}"))
}

/// A model that is refused.
pub(crate) fn model(why: impl std::fmt::Display) -> PyErr {
    ModelError::new_err(why.to_string())
}

/// What is wrong with recordings or the options beside them.
pub(crate) fn of_signals(error: &signals::Error) -> PyErr {
    match error {
        signals::Error::Parameter { .. } | signals::Error::Map { .. } => {
            TribosError::new_err(error.to_string())
        }
        _ => RecordingError::new_err(error.to_string()),
    }
}

/// What ended a procedure.
pub(crate) fn of_procedure(error: &procedures::Error) -> PyErr {
    let text = words(&error.to_string(), error.help());
    match error {
        procedures::Error::Recording(error) => of_signals(error),
        procedures::Error::Input { .. } => RecordingError::new_err(text),
        _ => TribosError::new_err(text),
    }
}

/// The exception for a diagnosis that failed.
pub(crate) fn of_diagnosis(error: &diagnose::Error) -> PyErr {
    match error {
        diagnose::Error::Recording(error) => of_signals(error),
        diagnose::Error::Option { .. } | diagnose::Error::Interrupted => {
            TribosError::new_err(error.to_string())
        }
        _ => RecordingError::new_err(error.to_string()),
    }
}
