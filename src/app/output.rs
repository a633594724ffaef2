//! Bytes that wait for the serial line.

use heapless::Deque;

/// Room for waiting bytes; at 921 600 baud 22 ms.
const ROOM: usize = 2048;
/// Bytes kept free for text, so that frames never crowd out news.
const FOR_TEXT: usize = 768;
/// Bytes that may wait before another command is taken up or a line of a long answer said. Below the rest of the
/// room, so that a flood of commands slows its own answers down and never costs a frame.
const BACKLOG: usize = 512;

/// What waits for the serial line. Text waits for room, a frame that finds none is dropped and counted.
#[derive(Debug, Clone, Default)]
pub struct Output {
    bytes: Deque<u8, ROOM>,
}

impl Output {
    /// Nothing waits.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: Deque::new() }
    }

    /// The next bytes to send, in one piece; there may be more behind.
    #[must_use]
    pub fn front(&self) -> &[u8] {
        match self.bytes.as_slices() {
            ([], rest) => rest,
            (front, _) => front,
        }
    }

    /// So many bytes of [`Self::front`] are sent.
    pub fn sent(&mut self, count: usize) {
        for _ in 0..count {
            if self.bytes.pop_front().is_none() {
                break;
            }
        }
    }

    /// Bytes that wait.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.bytes.len()
    }

    fn free(&self) -> usize {
        ROOM - self.bytes.len()
    }

    /// Enough waits: the next answer has time.
    #[must_use]
    pub(super) fn is_behind(&self) -> bool {
        self.bytes.len() >= BACKLOG
    }

    /// Room for a line of so many bytes with its end.
    #[must_use]
    pub(super) fn fits_line(&self, length: usize) -> bool {
        self.free() >= length + 2
    }

    /// A line of text. The caller has asked for room.
    pub(super) fn line(&mut self, line: &str) {
        self.put(line.as_bytes());
        self.put(b"\r\n");
    }

    /// A frame; false when there is no room for it.
    #[must_use]
    pub(super) fn frame(&mut self, wire: &[u8]) -> bool {
        let fits = self.free() >= wire.len() + FOR_TEXT;
        if fits {
            self.put(wire);
        }
        fits
    }

    fn put(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let _ = self.bytes.push_back(*byte);
        }
    }
}
