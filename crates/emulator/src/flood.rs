//! What nobody should send over a serial line: commands and garbage, as fast as the wire carries them.

/// What a piece of the flood is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A line that is obeyed.
    Command,
    /// A line that is refused: not a command, a value that is none or that is out of range.
    Refused,
    /// No line at all.
    Garbage,
}

/// Lines a user might type while the handle renders; none of them ends what runs.
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
    "render on off",
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
    state: u64,
}

impl Flood {
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// splitmix64 (Steele, Lea, Flood 2014).
    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// The next piece: a line with its end, or bytes without.
    pub fn piece(&mut self) -> (Kind, Vec<u8>) {
        match self.below(10) {
            0..5 => (Kind::Command, line(COMMANDS[self.below(COMMANDS.len())])),
            5..8 => (Kind::Refused, line(REFUSED[self.below(REFUSED.len())])),
            8 => {
                let length = 1 + self.below(300);
                (Kind::Garbage, (0..length).map(|_| self.next() as u8).collect())
            }
            _ => {
                let length = 200 + self.below(800);
                (Kind::Garbage, [vec![b'1'; length], b"\n".to_vec()].concat())
            }
        }
    }
}

fn line(text: &str) -> Vec<u8> {
    format!("{text}\n").into_bytes()
}
