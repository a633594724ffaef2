//! Failure of a command: one clear message and the exit code.

use report::picture::DrawError;
use signals::files::FileError;
use std::fmt;
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;

/// A command that ran.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Done,
    /// Exit code 1: the finding asked for with `--expect`, or the improvement asked for, is not there.
    ExpectedFindingAbsent,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Done => Self::from(0),
            Outcome::ExpectedFindingAbsent => Self::from(1),
        }
    }
}

/// A command that could not run: bad usage or bad input, exit code 2.
///
/// The message is one line and names the file with line and column, or the option, and the value that was
/// given; `help` says what would be accepted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    message: String,
    help: Option<String>,
}

impl Failure {
    /// A failure in one line.
    pub fn new(message: impl fmt::Display) -> Self {
        Self { message: one_line(&message.to_string()), help: None }
    }

    /// A failure about a file: `FILE: why`, unless `why` already begins with the file's name.
    pub fn in_file(path: &Path, why: impl fmt::Display) -> Self {
        let (path, why) = (path.display().to_string(), why.to_string());
        if why.starts_with(&path) { Self::new(why) } else { Self::new(format!("{path}: {why}")) }
    }

    /// What to do instead.
    #[must_use]
    pub fn help(mut self, help: impl fmt::Display) -> Self {
        self.help = Some(one_line(&help.to_string()));
        self
    }

    /// The one line.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }

    /// 2, as documented.
    #[must_use]
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(2)
    }

    /// Prints to standard error: with miette on a terminal, plain lines in a pipe.
    pub fn print(&self) {
        let mut stderr = std::io::stderr();
        let text = if stderr.is_terminal() {
            let mut drawn = String::new();
            match miette::GraphicalReportHandler::new().render_report(&mut drawn, self) {
                Ok(()) => format!("error:{drawn}"),
                Err(_) => self.plain(),
            }
        } else {
            self.plain()
        };
        // a closed standard error cannot be reported
        let _ = stderr.write_all(text.as_bytes());
    }

    fn plain(&self) -> String {
        match &self.help {
            Some(help) => format!("error: {}\n  help: {help}\n", self.message),
            None => format!("error: {}\n", self.message),
        }
    }
}

fn one_line(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    // the number of an operating-system error adds nothing for a user
    match line.find(" (os error ") {
        Some(at) if line.ends_with(')') => line[..at].to_owned(),
        _ => line,
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

/// What went wrong, and what its crate says to do about it.
macro_rules! with_help {
    ($($error:ty),* $(,)?) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                let failure = Self::new(&error);
                match error.help() {
                    Some(help) => failure.help(help),
                    None => failure,
                }
            }
        })*
    };
}

with_help!(benchmark::Error, client::Error, compare::Error, perception::study::Error, prove::Error);

impl From<procedures::Error> for Failure {
    fn from(error: procedures::Error) -> Self {
        let failure = match &error {
            procedures::Error::Option { option, why, .. } => {
                Self::new(format!("--{}: {why}", option.replace('_', "-")))
            }
            other => Self::new(other),
        };
        match error.help() {
            Some(help) => failure.help(help),
            None => failure,
        }
    }
}

/// What went wrong, where nothing more can be said.
macro_rules! plain {
    ($($error:ty),* $(,)?) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::new(error)
            }
        })*
    };
}

plain!(DrawError, FileError, design::Error, figures::Error);

impl miette::Diagnostic for Failure {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|h| Box::new(h) as Box<dyn fmt::Display>)
    }
}

/// What every command returns.
pub type Result<T> = std::result::Result<T, Failure>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_one_line_and_names_the_file_once() {
        let f = Failure::in_file(Path::new("a.csv"), "a.csv:3:2: `x` is not a\n number").help("numbers only");
        assert_eq!(f.plain(), "error: a.csv:3:2: `x` is not a number\n  help: numbers only\n");
        assert_eq!(Failure::in_file(Path::new("a.csv"), "empty").message(), "a.csv: empty");
    }
}
