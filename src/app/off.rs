//! The way of `off` from the serial line to the control step, past every queue.
//!
//! ```text
//! bytes ──▶ Listener ──────── bytes in turn ───────▶ Desk ──▶ `ok off`, in its turn
//!              └─ asked ──▶ ControlLoop: force off in the next step
//! ```
//!
//! A [`Listener`] sees each byte as it arrives. At the end of a line that means `off` it asks the control loop, which obeys in
//! its next step and denies requests that were made before. The same bytes then reach the desk in their turn. Until it has
//! read as many `off` lines as the listener, it refuses every command that would switch the force on: `off` came after it.

use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering::Relaxed};
use haptics::ModeId;
use link::OffDetector;

/// State shared by listener, control loop and desk.
#[derive(Debug, Default)]
pub struct OffSwitch {
    /// The control loop must switch the force off.
    asked: AtomicBool,
    /// `off` lines that the desk has yet to read.
    ahead: AtomicU32,
    /// Mode that `off` ended, as its code; 0 for none.
    ended: AtomicU8,
}

// Listener, control loop and desk preempt each other in this order on one core, so that a load followed by a store needs no
// atomic exchange where the other side has a lower priority.
impl OffSwitch {
    /// Asks the control loop to switch the force off.
    pub fn ask(&self) {
        self.asked.store(true, Relaxed);
    }

    /// Whether the control loop has yet to obey.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        self.asked.load(Relaxed)
    }

    /// Called by the control loop: true once after [`Self::ask`].
    pub(super) fn obey(&self) -> bool {
        let asked = self.asked.load(Relaxed);
        if asked {
            self.asked.store(false, Relaxed);
        }
        asked
    }

    /// Called by the control loop: `off` ended this mode.
    pub(super) fn has_ended(&self, mode: ModeId) {
        if mode != ModeId::Idle {
            self.ended.store(mode.code(), Relaxed);
        }
    }

    /// The mode that `off` ended since the last call; idle for none.
    pub(super) fn take_ended(&self) -> ModeId {
        ModeId::from_code(self.ended.swap(0, Relaxed)).unwrap_or_default()
    }

    /// Whether an `off` is ahead of the desk: it came after what the desk reads now.
    #[must_use]
    pub fn is_ahead(&self) -> bool {
        self.ahead.load(Relaxed) > 0
    }

    /// The desk has read an `off`.
    pub(super) fn was_read(&self) {
        // saturates: an `off` whose begin was lost before the listener queued it was not counted
        let _ = self.ahead.fetch_update(Relaxed, Relaxed, |ahead| ahead.checked_sub(1));
    }
}

/// Hears `off` in the bytes of the serial line as they arrive.
#[derive(Debug, Clone, Default)]
pub struct Listener {
    /// Of all bytes that arrive.
    heard: OffDetector,
    /// Of the bytes that the desk will read. They differ after a loss.
    queued: OffDetector,
    /// Bytes were lost since the last that was queued.
    gap: bool,
}

impl Listener {
    /// Begins at the begin of a line.
    #[must_use]
    pub const fn new() -> Self {
        Self { heard: OffDetector::new(), queued: OffDetector::new(), gap: false }
    }

    /// Bytes were lost before they could be heard.
    pub fn lose(&mut self) {
        self.heard = OffDetector::new();
        self.gap = true;
    }

    /// Takes one byte. `queue` passes a byte on to the desk and returns false without room. True if the byte completes an
    /// `off`, which the control loop then obeys, whether or not there was room.
    ///
    /// A zero byte stands in the place of lost bytes: the desk refuses the line with it, so that the halves of two commands are
    /// never obeyed as one.
    pub fn hear(&mut self, byte: u8, off: &OffSwitch, mut queue: impl FnMut(u8) -> bool) -> bool {
        let is_off = self.heard.push(byte);
        if self.gap && queue(0) {
            self.queued.push(0);
            self.gap = false;
        }
        if !self.gap && queue(byte) {
            if self.queued.push(byte) {
                off.ahead.fetch_add(1, Relaxed);
            }
        } else {
            self.gap = true;
        }
        if is_off {
            off.ask();
        }
        is_off
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn off_is_asked_for_without_room_in_the_queue() {
        let (mut listener, off) = (Listener::new(), OffSwitch::default());
        let heard = b"off\n".iter().map(|byte| listener.hear(*byte, &off, |_| false)).last();
        assert_eq!(heard, Some(true));
        assert!(off.obey() && !off.obey());
        assert!(!off.is_ahead(), "the desk will never read it");
    }

    #[test]
    fn lost_bytes_never_leave_an_off_ahead_that_the_desk_cannot_read() {
        // every place at which a queue of any size can overflow
        let typed = b"set dv 3\noff\nrender on\nof\x7fff\nstatus\noff\n";
        for lost_from in 0..typed.len() {
            for lost_to in lost_from..typed.len() {
                let (mut listener, off, mut queue) = (Listener::new(), OffSwitch::default(), Vec::new());
                let mut heard = 0;
                for (at, byte) in typed.iter().enumerate() {
                    let room = !(lost_from..lost_to).contains(&at);
                    heard += usize::from(listener.hear(*byte, &off, |byte| {
                        if room {
                            queue.push(byte);
                        }
                        room
                    }));
                }
                assert_eq!(heard, 3);
                let mut desk = OffDetector::new();
                for byte in queue {
                    if desk.push(byte) {
                        assert!(off.is_ahead());
                        off.was_read();
                    }
                }
                assert!(!off.is_ahead(), "lost {lost_from}..{lost_to}");
            }
        }
    }
}
