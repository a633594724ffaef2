//! Assembles bytes into lines on the device.

use core::fmt;
use heapless::String;

/// Longest line accepted, bytes.
pub const MAX_LINE: usize = 160;

/// A line that cannot be a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BadLine {
    /// Longer than [`MAX_LINE`], with its length in bytes.
    TooLong(u32),
    /// A byte that is not printable ASCII, with its column from 1.
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
            Self::TooLong(length) => write!(f, "line of {length} bytes; at most {MAX_LINE} are accepted"),
            Self::NotText(byte, column) => {
                write!(f, "byte 0x{byte:02x} in column {column}; only printable ASCII is accepted")
            }
        }
    }
}

impl core::error::Error for BadLine {}

/// Collects bytes up to a carriage return or line feed. Backspace and delete remove the last one.
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

    /// Takes one byte and returns the line once it is complete. Skips empty lines.
    ///
    /// # Errors
    /// [`BadLine`] at the end of a line that cannot be a command. No part of it may be executed.
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
                // bytes beyond the buffer, or not text, cannot be removed one by one
                if self.bad.is_none() && self.length as usize <= MAX_LINE && self.line.pop().is_some() {
                    self.length -= 1;
                }
                return None;
            }
            b' '..=b'~' | b'\t' => {
                // bytes that do not fit are only counted
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
    fn lines_end_with_cr_or_lf_or_both() {
        let expected: Vec<_> = ["help", "stop", "get dv"].map(|s| Ok(Text::from(s))).into();
        assert_eq!(lines(b"help\nstop\r\n\n\rget dv\r"), expected);
        assert_eq!(lines(b"half a line"), []);
    }

    #[test]
    fn backspace_removes_a_byte() {
        assert_eq!(lines(b"\x08stpp\x7f\x08op\n"), [Ok("stop".into())]);
    }

    #[test]
    fn bad_lines_are_reported_and_end_with_their_line() {
        let mut bytes = Vec::from(&b"get \xff\x00 dv\n"[..]);
        bytes.extend([b'x'; 1000]);
        bytes.extend(b"\nstop\n");
        let got = lines(&bytes);
        assert_eq!(got, [Err(BadLine::NotText(0xff, 5)), Err(BadLine::TooLong(1000)), Ok("stop".into())]);
        assert_eq!(
            got[0].clone().unwrap_err().to_string(),
            "byte 0xff in column 5; only printable ASCII is accepted"
        );
    }

    #[test]
    fn the_longest_line_is_accepted() {
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
