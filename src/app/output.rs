//! Output buffer of the serial line.

use heapless::Deque;

/// Size of the buffer, bytes: 22 ms at 921 600 baud.
const ROOM: usize = 2048;
/// Bytes reserved for text, so that frames never displace messages.
const FOR_TEXT: usize = 768;
/// Number of bytes up to the last text from which on new answers wait. Less than the frames' share: answers never cost a frame.
const BACKLOG: usize = 512;

/// Output buffer. Text waits for room; a frame without room is dropped and counted.
#[derive(Debug, Clone, Default)]
pub struct Output {
    bytes: Deque<u8, ROOM>,
    /// Number of bytes to send until the last text is out.
    text: usize,
}

impl Output {
    /// Whether the buffer is empty.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: Deque::new(), text: 0 }
    }

    /// Next contiguous bytes to send. More may follow.
    #[must_use]
    pub fn front(&self) -> &[u8] {
        match self.bytes.as_slices() {
            ([], rest) => rest,
            (front, _) => front,
        }
    }

    /// Removes sent bytes of [`Self::front`].
    pub fn sent(&mut self, count: usize) {
        self.text = self.text.saturating_sub(count);
        for _ in 0..count {
            if self.bytes.pop_front().is_none() {
                break;
            }
        }
    }

    /// Number of waiting bytes.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.bytes.len()
    }

    fn free(&self) -> usize {
        ROOM - self.bytes.len()
    }

    /// Whether the next answer should wait. Frames alone hold nothing up: a stream that fills the line could not be ended.
    #[must_use]
    pub(super) fn is_behind(&self) -> bool {
        self.text >= BACKLOG
    }

    /// Whether a line of this length fits, terminator included.
    #[must_use]
    pub(super) fn fits_line(&self, length: usize) -> bool {
        self.free() >= length + 2
    }

    /// Appends a line of text. The caller checked the room.
    pub(super) fn line(&mut self, line: &str) {
        self.put(line.as_bytes());
        self.put(b"\r\n");
        self.text = self.bytes.len();
    }

    /// Appends a frame. False without room.
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
