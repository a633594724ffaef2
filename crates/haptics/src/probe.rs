//! The push of the self-test. Open loop, because a controller would run away with any wrong sign.
//!
//! ```text
//! force   ramp until it moves      + one part    - two parts    + one part
//!         ___/                     ‾‾‾‾‾‾‾‾‾‾    ____________   ‾‾‾‾‾‾‾‾‾‾   off
//! ```
//!
//! The handle moves back and forth by about a millimetre and ends at rest where it was. The push always ends with the
//! amplifier off, also when the largest force moved nothing or the handle moved too far.

use crate::Device;

/// Growth of the force until the handle moves, N/s. This and the next two are those of the default device; others scale them.
const RATE: f32 = 20.0;
/// Largest share of the actuator's force.
const LIMIT: f32 = 0.8;
/// Force above the one that moved the handle, N.
const EXTRA: f32 = 1.5;
/// Motion that counts as moved, counts.
const MOVED: u32 = 20;
/// Length of one part of the pattern, s.
const PART_S: f32 = 0.02;
/// Largest distance from the start, m.
const FAR: f32 = 3.5e-3;

/// A running push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    start: u32,
    force: f32,
    /// Periods since the handle moved.
    moved: Option<u32>,
}

impl Probe {
    /// Room needed on either side, m.
    pub(crate) fn room(device: &Device) -> f32 {
        device.length(FAR + 1e-3)
    }

    pub(crate) fn start(count: u32) -> Self {
        Self { start: count, force: 0.0, moved: None }
    }

    /// One period: the force, N, or `None` after the end.
    pub(crate) fn step(&mut self, device: &Device, count: u32) -> Option<f32> {
        let travel = (count.wrapping_sub(self.start) as i32).unsigned_abs();
        if travel as f32 * device.metre_per_count > device.length(FAR) {
            return None;
        }
        let Some(periods) = &mut self.moved else {
            self.force += device.force(RATE) * device.period;
            if travel >= MOVED {
                self.moved = Some(0);
                self.force += device.force(EXTRA);
            }
            return Some(self.force).filter(|force| *force <= LIMIT * device.force_max + device.force(EXTRA));
        };
        *periods = periods.saturating_add(1);
        let part = *periods as f32 * device.period;
        if part < PART_S || (3.0 * PART_S..4.0 * PART_S).contains(&part) {
            Some(self.force)
        } else if part < 3.0 * PART_S {
            Some(-self.force)
        } else {
            None
        }
    }
}
