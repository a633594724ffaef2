//! The push of the self-test: open loop, because a wrong sign anywhere would make a controller run away.
//!
//! ```text
//! force   ramp until it moves      + one part    - two parts    + one part
//!         ___/                     ‾‾‾‾‾‾‾‾‾‾    ____________   ‾‾‾‾‾‾‾‾‾‾   off
//! ```
//!
//! The handle moves by some millimetre to and fro and is left where it was, at rest. The push ends with the amplifier
//! off whatever happens: when it was pushed as far as is allowed and nothing moved, and when it moved too far.

use crate::Device;

/// Growth of the force until the handle moves, N/s.
const RATE: f32 = 20.0;
/// Share of the actuator's force beyond which nothing is tried.
const LIMIT: f32 = 0.8;
/// Force beyond the one that made it move, N.
const EXTRA: f32 = 1.5;
/// Motion, counts.
const MOVED: u32 = 20;
/// One part of the pattern, s.
const PART_S: f32 = 0.02;
/// Farthest from where it began, m.
const FAR: f32 = 3.5e-3;

/// A push under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    start: u32,
    force: f32,
    /// Periods since the handle moved.
    moved: Option<u32>,
}

impl Probe {
    /// Room that it needs on either side, m.
    pub const ROOM: f32 = FAR + 1e-3;

    pub(crate) fn start(count: u32) -> Self {
        Self { start: count, force: 0.0, moved: None }
    }

    /// One period: the force in N, or `None` when it is over.
    pub(crate) fn step(&mut self, device: &Device, count: u32) -> Option<f32> {
        let travel = (count.wrapping_sub(self.start) as i32).unsigned_abs();
        if travel as f32 * device.metre_per_count > FAR {
            return None;
        }
        let Some(periods) = &mut self.moved else {
            self.force += RATE * device.period;
            if travel >= MOVED {
                self.moved = Some(0);
                self.force += EXTRA;
            }
            return Some(self.force).filter(|force| *force <= LIMIT * device.force_max + EXTRA);
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
