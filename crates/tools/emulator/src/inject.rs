//! What a test puts in place of the rig: readings sample by sample, or edges of the encoder at an even pace.

use std::fmt;

/// Register values from the end of a conversion on. The rig continues without effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Injected {
    /// First result of the sequence: load cell.
    pub load_code: u16,
    /// Second result: accelerometer.
    pub accel_code: u16,
    /// Count of TIM2.
    pub count: u32,
    /// Time since the edge captured by TIM5, ticks. `None` keeps the capture.
    pub edge_age: Option<u32>,
    /// Jump of the count of TIM5, ticks.
    pub skew_ticks: u32,
}

/// Gives the next readings.
pub(crate) struct Injector(pub Box<dyn FnMut() -> Injected + Send>);

impl fmt::Debug for Injector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Injector")
    }
}

/// Edges at an even pace.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pulses {
    /// Time of the next edge, units.
    pub next: u64,
    /// Units between two.
    pub interval: u64,
    /// Whether they count up.
    pub up: bool,
}

impl Pulses {
    /// The next edge, if it is due.
    pub fn due(&mut self, now: u64) -> Option<(u64, bool)> {
        let at = self.next;
        (at <= now).then(|| {
            self.next += self.interval;
            (at, self.up)
        })
    }
}
