//! Motions that measure the device itself. Open loop, because a controller would run away with any wrong sign.
//!
//! The push of the self-test:
//!
//! ```text
//! force   ramp until it moves      + one part    - two parts    + one part
//!         ___/                     ‾‾‾‾‾‾‾‾‾‾    ____________   ‾‾‾‾‾‾‾‾‾‾   off
//! ```
//!
//! The handle moves back and forth by about a millimetre and ends at rest where it was. The push always ends with the
//! amplifier off, also when the largest force moved nothing or the handle moved too far.
//!
//! The ramp of the calibration of the force, while a person holds the handle: 0, up to half of the largest force, down to the
//! same below 0, up again, 0. It ends with the amplifier off when the handle moved too far.

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

/// Largest force of the ramp, as a share of the actuator's.
const RAMP_SHARE: f32 = 0.5;
/// Time in which the ramp rises to it, s.
const QUARTER_S: f32 = 2.0;
/// Largest distance from the start during the ramp, m.
const RAMP_FAR: f32 = 8e-3;

/// A running measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Probe {
    /// The push of the self-test.
    Push(Push),
    /// The ramp of the calibration of the force.
    Ramp(Ramp),
}

/// A running push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Push {
    start: u32,
    force: f32,
    /// Periods since the handle moved.
    moved: Option<u32>,
}

/// A running ramp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ramp {
    start: u32,
    periods: u32,
}

impl Probe {
    /// Room that a push needs on either side, m.
    pub(crate) fn room(device: &Device) -> f32 {
        device.length(FAR + 1e-3)
    }

    pub(crate) fn push(count: u32) -> Self {
        Self::Push(Push { start: count, force: 0.0, moved: None })
    }

    pub(crate) fn ramp(count: u32) -> Self {
        Self::Ramp(Ramp { start: count, periods: 0 })
    }

    /// One period: the force, N, or `None` after the end.
    pub(crate) fn step(&mut self, device: &Device, count: u32) -> Option<f32> {
        match self {
            Self::Push(push) => push.step(device, count),
            Self::Ramp(ramp) => ramp.step(device, count),
        }
    }
}

/// Distance travelled, counts.
fn travel(start: u32, count: u32) -> u32 {
    (count.wrapping_sub(start) as i32).unsigned_abs()
}

impl Ramp {
    /// Length, s.
    pub const SECONDS: f32 = 6.0 * QUARTER_S;

    /// Largest force on this device, N.
    #[must_use]
    pub fn peak(device: &Device) -> f32 {
        RAMP_SHARE * device.force_max
    }

    /// Largest distance from the start, m.
    #[must_use]
    pub fn far(device: &Device) -> f32 {
        device.length(RAMP_FAR)
    }

    fn step(&mut self, device: &Device, count: u32) -> Option<f32> {
        self.periods = self.periods.saturating_add(1);
        let quarters = self.periods as f32 * (device.period / QUARTER_S);
        let far = travel(self.start, count) as f32 * device.metre_per_count > Self::far(device);
        if far || quarters > 6.0 {
            return None;
        }
        // up, down for two quarters, up for two, down
        let share = if quarters < 1.0 {
            quarters
        } else if quarters < 3.0 {
            2.0 - quarters
        } else if quarters < 5.0 {
            quarters - 4.0
        } else {
            6.0 - quarters
        };
        Some(share * Self::peak(device))
    }
}

impl Push {
    fn step(&mut self, device: &Device, count: u32) -> Option<f32> {
        let travel = travel(self.start, count);
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
