//! Separates text from frames on the host.

use crate::{Frame, MAX_WIRE, decode_payload};
use heapless::Vec;

/// Longest line of text from a device, bytes.
const MAX_TEXT: usize = 1024;
/// First byte of every frame.
const FRAME: u8 = 1;

/// Decoded item.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; one at a time
pub enum Item<'a> {
    /// A line without its terminator.
    Text(&'a str),
    /// A frame with its sequence number.
    Frame(u32, Frame),
    /// Bytes that are neither; they are lost.
    Corrupt(Corrupt),
}

/// Reason why bytes were lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Corrupt {
    /// A frame with a wrong check sum or format.
    Frame,
    /// A line that is too long or has bytes that are not text.
    Text,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reading {
    Nothing,
    Text,
    Frame,
}

/// Decoder of the bytes from a device. After corrupt bytes it resynchronises at the end of the next frame or line.
#[derive(Debug, Clone)]
pub struct Decoder {
    reading: Reading,
    buffer: Vec<u8, MAX_TEXT>,
    overlong: bool,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// Start of a line.
    #[must_use]
    pub const fn new() -> Self {
        Self { reading: Reading::Nothing, buffer: Vec::new(), overlong: false }
    }

    /// Takes one byte.
    pub fn push(&mut self, byte: u8) -> Option<Item<'_>> {
        if self.reading == Reading::Nothing {
            self.buffer.clear();
            self.overlong = false;
            self.reading = match byte {
                // end of an item whose start was lost
                0 => return None,
                b'\r' | b'\n' => return None,
                FRAME => Reading::Frame,
                _ => Reading::Text,
            };
        }
        let ends = match self.reading {
            Reading::Frame => byte == 0,
            // a zero ends a frame whose start was lost
            _ => byte == b'\n' || byte == 0,
        };
        if !ends {
            let longest = if self.reading == Reading::Frame { MAX_WIRE } else { MAX_TEXT };
            if self.buffer.len() >= longest || self.buffer.push(byte).is_err() {
                self.overlong = true;
            }
            return None;
        }
        let was = core::mem::replace(&mut self.reading, Reading::Nothing);
        if was == Reading::Frame {
            return Some(
                self.frame().map_or(Item::Corrupt(Corrupt::Frame), |(seq, frame)| Item::Frame(seq, frame)),
            );
        }
        if self.overlong || byte == 0 {
            return Some(Item::Corrupt(Corrupt::Text));
        }
        while self.buffer.last() == Some(&b'\r') {
            self.buffer.pop();
        }
        let text = core::str::from_utf8(&self.buffer).ok();
        let text = text.filter(|text| !text.contains(|c: char| c.is_control() && c != '\t'));
        Some(text.map_or(Item::Corrupt(Corrupt::Text), Item::Text))
    }

    fn frame(&mut self) -> Option<(u32, Frame)> {
        if self.overlong {
            return None;
        }
        let mut payload = [0; MAX_WIRE];
        let report = cobs::decode(&self.buffer, &mut payload).ok()?;
        decode_payload(payload.get(..report.frame_size())?)
    }
}
