//! Bytes into lines, on the device's side.

use core::fmt;
use heapless::String;

/// Longest line accepted, bytes.
pub const MAX_LINE: usize = 160;

/// A line that cannot be a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BadLine {
    /// Longer than [`MAX_LINE`]: its length, bytes.
    TooLong(u32),
    /// A byte that is not printable ASCII: the byte, and its column from 1.
    NotText(u8, u32),
}

impl BadLine {
    /// Code of the `err` answer.
    #[must_use]
    pub fn code(self) -> &'static str {
        match self {
            Self::TooLong(_) => "TOO_LONG",
            Self::NotText(..) => "NOT_TEXT",
        }
    }
}

impl fmt::Display for BadLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong(length) => write!(f, "a line of {length} bytes; accepted are {MAX_LINE}"),
            Self::NotText(byte, column) => {
                write!(f, "byte 0x{byte:02x} in column {column}; accepted is printable ASCII")
            }
        }
    }
}

impl core::error::Error for BadLine {}

/// Collects bytes until a carriage return or a line feed; backspace and delete take one back.
#[derive(Debug, Clone, Default)]
pub struct LineEditor {
    line: String<MAX_LINE>,
    length: u32,
    bad: Option<(u8, u32)>,
    done: bool,
}

impl LineEditor {
    /// An empty line.
    #[must_use]
    pub const fn new() -> Self {
        Self { line: String::new(), length: 0, bad: None, done: false }
    }

    /// Takes one byte; the line when it is complete. Empty lines are skipped.
    ///
    /// # Errors
    /// [`BadLine`] at the end of a line that cannot be a command: nothing of it is to be obeyed.
    pub fn push(&mut self, byte: u8) -> Option<Result<&str, BadLine>> {
        if self.done {
            *self = Self::new();
        }
        match byte {
            b'\r' | b'\n' => {
                if self.length == 0 {
                    return None;
                }
                self.done = true;
                if let Some((byte, column)) = self.bad {
                    return Some(Err(BadLine::NotText(byte, column)));
                }
                if self.length as usize > MAX_LINE {
                    return Some(Err(BadLine::TooLong(self.length)));
                }
                return Some(Ok(&self.line));
            }
            8 | 127 => {
                // what is beyond the buffer or not text cannot be taken back byte by byte
                if self.bad.is_none() && self.length as usize <= MAX_LINE && self.line.pop().is_some() {
                    self.length -= 1;
                }
                return None;
            }
            b' '..=b'~' | b'\t' => {
                // what does not fit only counts
                let _ = self.line.push(char::from(byte));
            }
            _ => {
                let column = self.length.saturating_add(1);
                self.bad.get_or_insert((byte, column));
            }
        }
        self.length = self.length.saturating_add(1);
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::{String as Text, ToString};
    use std::vec::Vec;

    fn lines(bytes: &[u8]) -> Vec<Result<Text, BadLine>> {
        let mut editor = LineEditor::new();
        bytes.iter().filter_map(|b| editor.push(*b).map(|line| line.map(Text::from))).collect()
    }

    #[test]
    fn lines_end_with_either_or_both() {
        let expected: Vec<_> = ["help", "stop", "get dv"].map(|s| Ok(Text::from(s))).into();
        assert_eq!(lines(b"help\nstop\r\n\n\rget dv\r"), expected);
        assert_eq!(lines(b"half a line"), []);
    }

    #[test]
    fn backspace_takes_back() {
        assert_eq!(lines(b"\x08stpp\x7f\x08op\n"), [Ok("stop".into())]);
    }

    #[test]
    fn garbage_and_long_lines_are_told_and_over_with_their_end() {
        let mut bytes = Vec::from(&b"get \xff\x00 dv\n"[..]);
        bytes.extend([b'x'; 1000]);
        bytes.extend(b"\nstop\n");
        let got = lines(&bytes);
        assert_eq!(got, [Err(BadLine::NotText(0xff, 5)), Err(BadLine::TooLong(1000)), Ok("stop".into())]);
        assert_eq!(
            got[0].clone().unwrap_err().to_string(),
            "byte 0xff in column 5; accepted is printable ASCII"
        );
    }

    #[test]
    fn exactly_the_longest_line_is_taken() {
        let mut bytes = Vec::from([b'a'; MAX_LINE]);
        bytes.push(b'\n');
        assert!(lines(&bytes)[0].is_ok());
        bytes.insert(0, b'a');
        assert_eq!(lines(&bytes), [Err(BadLine::TooLong(MAX_LINE as u32 + 1))]);
    }

    proptest::proptest! {
        #[test]
        fn any_bytes_are_survived_and_the_next_line_is_heard(bytes: Vec<u8>) {
            let mut all = bytes;
            all.extend(b"\nstatus\n");
            proptest::prop_assert_eq!(lines(&all).pop(), Some(Ok("status".into())));
        }
    }
}
