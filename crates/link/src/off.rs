//! Detection of `off` in raw bytes, ahead of every queue, length limit and parser.

/// Recognises a line whose first word is `off`, in upper or lower case.
///
/// It is more lenient than the parser, because this line must not fail: unprintable bytes are skipped, words after `off` are
/// ignored, and a line may have any length. Backspace and delete remove a character, as in [`crate::LineEditor`]. A zero byte
/// marks lost bytes and begins a new line.
///
/// ```
/// let mut detector = link::OffDetector::new();
/// assert!(!b"render off\r\n".iter().any(|byte| detector.push(*byte)));
/// assert!(b"off\n".iter().any(|byte| detector.push(*byte)));
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OffDetector {
    /// First characters of the line.
    first: [u8; 4],
    /// Number of characters of the line, saturating.
    length: u32,
}

impl OffDetector {
    /// At the begin of a line.
    #[must_use]
    pub const fn new() -> Self {
        Self { first: [0; 4], length: 0 }
    }

    /// Takes one byte. True at the end of a line that means `off`.
    pub fn push(&mut self, byte: u8) -> bool {
        match byte {
            b'\r' | b'\n' => return core::mem::take(self).is_off(),
            0 => *self = Self::new(),
            8 | 127 => self.length = self.length.saturating_sub(1),
            b' ' | b'\t' if self.length == 0 => {}
            b' '..=b'~' | b'\t' => {
                if let Some(place) = self.first.get_mut(self.length as usize) {
                    *place = byte;
                }
                self.length = self.length.saturating_add(1);
            }
            _ => {}
        }
        false
    }

    fn is_off(self) -> bool {
        let [a, b, c, after] = self.first;
        let word_ends = self.length == 3 || matches!(after, b' ' | b'\t');
        self.length >= 3 && word_ends && [a, b, c].eq_ignore_ascii_case(b"off")
    }
}

#[cfg(test)]
mod tests {
    use super::OffDetector;
    use crate::{Command, LineEditor};
    use proptest::prelude::*;
    use std::{string::ToString, vec, vec::Vec};

    fn count(bytes: &[u8]) -> usize {
        let mut detector = OffDetector::new();
        bytes.iter().filter(|byte| detector.push(**byte)).count()
    }

    #[test]
    fn off_is_found_in_any_clothes() {
        for bytes in [
            b"off\n".as_slice(),
            b"off\r\n",
            b"  off \t\n",
            b"OFF\n",
            b"off now!\n",
            b"\xff\xfeof\x80f\n",
            b"set dv 0.\noff\n",
            b"set dv 0.\0off\n",
            b"ox\x7fff\n",
            b"ofg\x08f\n",
        ] {
            assert_eq!(count(bytes), 1, "{:?}", bytes.escape_ascii().to_string());
        }
        assert_eq!(count(&[vec![b'x'; 100_000], b"\noff\noff\n".to_vec()].concat()), 2);
    }

    #[test]
    fn other_lines_are_not_off() {
        for bytes in [
            b"off".as_slice(),
            b"render off\n",
            b"stream off\n",
            b"offset\n",
            b"of\n",
            b"of f\n",
            b"off\x7f\n",
            b"\n\r\n",
        ] {
            assert_eq!(count(bytes), 0, "{:?}", bytes.escape_ascii().to_string());
        }
    }

    proptest! {
        /// Whatever the parser takes for `off` the detector finds, too, in the same place.
        #[test]
        fn nothing_the_parser_obeys_is_missed(bytes in prop::collection::vec(
            prop_oneof![Just(b'o'), Just(b'f'), Just(b' '), Just(b'\n'), Just(8_u8), any::<u8>()], 0..60)) {
            let (mut editor, mut detector) = (LineEditor::new(), OffDetector::new());
            for byte in bytes {
                let obeyed = matches!(
                    editor.push(byte),
                    Some(Ok(line)) if matches!(Command::parse(line), Ok(Some(Command::Off)))
                );
                let found = detector.push(byte);
                prop_assert!(found || !obeyed);
            }
        }

        #[test]
        fn off_after_anything_is_found(mut bytes: Vec<u8>) {
            bytes.extend(b"\noff\n");
            let mut detector = OffDetector::new();
            let last = bytes.iter().map(|byte| detector.push(*byte)).last();
            prop_assert_eq!(last, Some(true));
        }
    }
}
