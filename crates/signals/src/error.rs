//! What can be wrong with a recording or a request, each as one line.

use std::fmt;

/// Why a recording was not read, prepared or fitted. One line, with the place, the value found and what would be
/// accepted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The file could not be opened, read or written.
    #[error("{file}: {}", OneLine(why))]
    File {
        /// File.
        file: String,
        /// What the system said, or what kind of file it is instead.
        why: String,
    },
    /// Something at one place of a file.
    #[error("{file}{place}: {}{}", Found(value).within(40), OneLine(accepted.trim_start_matches([':', ' '])))]
    Input {
        /// File.
        file: String,
        /// Line and column.
        place: Place,
        /// What was found there; empty where something is missing.
        value: String,
        /// What is wrong, and what would be accepted.
        accepted: String,
    },
    /// A `--map` text that cannot be used.
    #[error("map, column {column}: {} in {}", OneLine(why), Found(map).within(200).trim_end())]
    Map {
        /// The text.
        map: String,
        /// Column in the text, characters from 1.
        column: usize,
        /// What is wrong, and what would be accepted.
        why: String,
    },
    /// An option outside what is accepted.
    #[error("{parameter} = {value}: {accepted}")]
    Parameter {
        /// Name.
        parameter: String,
        /// What was asked for.
        value: String,
        /// What would be accepted.
        accepted: String,
    },
    /// The recording does not hold what the method needs.
    #[error("{recording}: {}", OneLine(why))]
    Recording {
        /// Its name.
        recording: String,
        /// What is missing, with the number found and the number that would do.
        why: String,
    },
}

/// A place in a file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// Line of the file from 1, comments counted.
    pub line: Option<u64>,
    /// Column of the table from 1, and its name; without a name, the character in the line from 1.
    pub column: Option<(usize, String)>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        match &self.column {
            Some((number, name)) if name.is_empty() => write!(f, ":{number}"),
            Some((number, name)) => write!(f, ": column {number} ({name})"),
            None => Ok(()),
        }
    }
}

/// The offending value in quotes, on one line and not longer than a line.
struct Found<'a>(&'a str);

impl Found<'_> {
    fn within(&self, longest: usize) -> String {
        if self.0.is_empty() {
            return String::new();
        }
        let mut shown: String = self.0.chars().take(longest).flat_map(escaped).collect();
        if self.0.chars().nth(longest).is_some() {
            shown.push('…');
        }
        format!("`{shown}` ")
    }
}

/// A sentence with names from a file, which may hold anything.
struct OneLine<'a>(&'a str);

impl fmt::Display for OneLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().flat_map(escaped).try_for_each(|c| fmt::Write::write_char(f, c))
    }
}

/// Control characters would break the line; quotes and backslashes are fine as they are.
fn escaped(c: char) -> Vec<char> {
    if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') { c.escape_debug().collect() } else { vec![c] }
}
