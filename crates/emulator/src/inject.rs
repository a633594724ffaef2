//! Readings made up by a test: what the converters, the encoder and the clock of the edges say, sample by sample.

use std::fmt;

/// What the registers say from the end of a conversion on. The rig goes on, unheard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Injected {
    /// First result of the sequence: load cell.
    pub load_code: u16,
    /// Second result: accelerometer.
    pub accel_code: u16,
    /// Count of TIM2.
    pub count: u32,
    /// From the edge that TIM5 has captured to now, ticks; `None` leaves the capture as it is.
    pub edge_age: Option<u32>,
    /// Moves the count of TIM5 by this much: the clock jumps.
    pub skew_ticks: u32,
}

/// Gives the next readings.
pub(crate) struct Injector(pub Box<dyn FnMut() -> Injected + Send>);

impl fmt::Debug for Injector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Injector")
    }
}
