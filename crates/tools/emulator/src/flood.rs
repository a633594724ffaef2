//! A flood of commands and garbage at the full rate of the serial line.

use crate::random::Random;

/// Kind of a piece of the flood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A valid line.
    Command,
    /// A line that is refused: not a command, not a number, or out of range.
    Refused,
    /// Garbage without lines.
    Garbage,
}

/// Lines that a user may type while the handle renders. None of them ends the rendering.
const COMMANDS: [&str; 12] = [
    "status",
    "version",
    "get dv",
    "get",
    "preset list",
    "preset show brass",
    "preset use brass",
    "preset use teflon",
    "preset use rubber",
    "set f_dynamic 1.5",
    "watch 30",
    "help",
];

/// Lines that must change nothing.
const REFUSED: [&str; 14] = [
    "rendre on",
    "render",
    "render on on",
    "set",
    "set dv",
    "set dv NaN",
    "set f_static nan",
    "set k_vc -inf",
    "set b_vc inf",
    "set mass 1e39",
    "set f_static 1e9",
    "preset use granite",
    "move sine NaN 2",
    "stream on 0.5",
];

/// A seeded, endless flood.
#[derive(Debug, Clone)]
pub(crate) struct Flood {
    random: Random,
}

impl Flood {
    pub fn new(seed: u64) -> Self {
        Self { random: Random(seed) }
    }

    /// Next piece: a line with its terminator, or bytes without.
    pub fn piece(&mut self) -> (Kind, Vec<u8>) {
        match self.random.below(10) {
            0..5 => (Kind::Command, line(COMMANDS[self.random.below(COMMANDS.len())])),
            5..8 => (Kind::Refused, line(REFUSED[self.random.below(REFUSED.len())])),
            8 => {
                let length = 1 + self.random.below(300);
                (Kind::Garbage, (0..length).map(|_| self.random.draw() as u8).collect())
            }
            _ => {
                let length = 200 + self.random.below(800);
                (Kind::Garbage, [vec![b'1'; length], b"\n".to_vec()].concat())
            }
        }
    }
}

fn line(text: &str) -> Vec<u8> {
    format!("{text}\n").into_bytes()
}
