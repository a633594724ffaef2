//! Search for the middle of the stroke: to one stop, to the other, and back to the middle between them.
//!
//! ```text
//! TO_LOW ── stop ──▶ TO_HIGH ── stop, at the device's stroke ──▶ BACK ── middle ──▶ SETTLE ──▶ referenced
//!    └────────────────────┴── no stop, another stroke, too fast, too long ──▶ amplifier off, unreferenced
//! ```
//!
//! A reference moves at a constant speed; a PD controller with the gains of the excitation follows it. The reference leads by
//! no more than the distance that takes the largest force, so that a blocked handle is pushed with that force and no impulse
//! is stored. A stop is where the handle rests under that force. Both stops yield by the same distance, which leaves the middle.
//!
//! Wrong wiring runs away: it is faster than the search, which ends there with the amplifier off.

use crate::Device;
use crate::filter::{Biquad, BiquadState};

/// Speed of the reference, as a share of `Device::overspeed`: 20 mm/s by default.
const SPEED: f32 = 0.02;
/// Largest speed of the handle, as a share of `Device::overspeed`. A handle that breaks loose slips at a third of it.
const FASTEST: f32 = 0.1;
/// Largest force, as a share of the actuator's: 6.6 N by default. The heaviest block of [thesis, table 3-3] on the guide of
/// [thesis, table 3-1] breaks away at 4.9 N.
const FORCE: f32 = 0.7;
/// Share of that force from which on the handle counts as pushed.
const PUSHED: f32 = 0.95;
/// Largest deviation of the measured stroke, as a share of the device's. Half of it is less than the millimetre that an
/// excitation keeps from the stops.
const TOLERANCE: f32 = 0.03;
/// Motion that is rest, m, on the default device.
const REST_M: f32 = 1e-4;
/// Rest under the largest force that is a stop, s.
const PUSHED_S: f32 = 0.25;
/// Time in the middle before the amplifier is switched off, s.
const SETTLE_S: f32 = 0.3;
/// Longest search, as a multiple of the time for one stroke. From anywhere it takes at most 2.5 of them and two stops.
const PATIENCE: f32 = 6.0;

/// Result of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Homed {
    /// Both stops are where the device's stroke has them; the handle is in the middle.
    Middle {
        /// Measured stroke, m.
        stroke: f32,
    },
    /// The stops have another distance than the device's stroke.
    Stroke {
        /// Measured stroke, m.
        measured: f32,
    },
    /// The handle travelled further than the stroke and met no stop.
    NoStop,
    /// The handle moved faster than a search.
    TooFast,
    /// It took too long.
    TooLong,
    /// `stop`, `off` or a fault came first.
    Interrupted,
}

/// Constants of a search in the units of the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    /// Periods in a second.
    rate: f32,
    metre_per_count: f32,
    /// Gains of the controller, N/m and N·s/m.
    stiffness: f32,
    damping: f32,
    low_pass: Biquad,
    /// Accepted strokes, m.
    strokes: (f32, f32),
    /// Travel of the reference in a period, m.
    advance: f32,
    /// Largest speed of the handle, m/s.
    fastest: f32,
    /// Largest force, N.
    force: f32,
    /// Largest distance of the reference from the handle, m.
    lead: f32,
    /// Rest, counts.
    rest: u32,
    /// Longest way to a stop, counts.
    longest: u32,
    pushed: u32,
    settle: u32,
    patience: u32,
}

impl Bounds {
    pub fn new(device: &Device) -> Self {
        let speed = SPEED * device.overspeed;
        let force = FORCE * device.force_max;
        // `as` saturates and maps NaN to 0
        let periods = |seconds: f32| (seconds / device.period) as u32;
        let counts = |metre: f32| (metre / device.metre_per_count) as u32;
        Self {
            rate: 1.0 / device.period,
            metre_per_count: device.metre_per_count,
            stiffness: device.tracking_stiffness,
            damping: device.tracking_damping,
            low_pass: Biquad::low_pass(device.command_cutoff_hz, device.period),
            strokes: Homed::accepted(device),
            advance: speed * device.period,
            fastest: FASTEST * device.overspeed,
            force,
            lead: force / device.tracking_stiffness,
            rest: counts(device.length(REST_M)).max(1),
            longest: counts((1.0 + TOLERANCE) * device.stroke),
            pushed: periods(PUSHED_S),
            settle: periods(SETTLE_S),
            patience: periods(PATIENCE * device.stroke / speed),
        }
    }
}

impl Homed {
    /// Strokes that a search accepts on this device, m: smallest and largest.
    #[must_use]
    pub fn accepted(device: &Device) -> (f32, f32) {
        ((1.0 - TOLERANCE) * device.stroke, (1.0 + TOLERANCE) * device.stroke)
    }
}

/// Where the search is. Counts are those of the encoder.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    ToLow,
    ToHigh { low: u32 },
    Back { middle: u32, stroke: f32 },
    Settle { middle: u32, stroke: f32 },
}

/// A running search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Homing {
    phase: Phase,
    /// Position of the reference relative to the handle, m.
    lead: f32,
    filter: BiquadState,
    /// Count at which this way began.
    began: u32,
    /// Count around which the handle rests.
    around: u32,
    /// Count of the previous step.
    previous: u32,
    /// Periods of rest.
    rested: u32,
    elapsed: u32,
}

/// Result of a step of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Progress {
    /// Command, N.
    Force(f32),
    /// The end, and the count of the middle if it was found.
    End(Homed, u32),
}

impl Homing {
    pub(crate) fn start(count: u32) -> Self {
        Self {
            phase: Phase::ToLow,
            lead: 0.0,
            filter: BiquadState::default(),
            began: count,
            around: count,
            previous: count,
            rested: 0,
            elapsed: 0,
        }
    }

    /// Distance of the reference from the handle, m.
    #[must_use]
    pub fn lead(&self) -> f32 {
        self.lead
    }

    /// One period. Not in the step of a contact, whose cycles are short.
    #[inline(never)]
    pub(crate) fn step(&mut self, bounds: &Bounds, count: u32, velocity: f32) -> Progress {
        self.elapsed = self.elapsed.saturating_add(1);
        if self.elapsed > bounds.patience {
            return Progress::End(Homed::TooLong, count);
        }
        if !(velocity.abs() <= bounds.fastest) {
            return Progress::End(Homed::TooFast, count);
        }
        let travelled = between(self.previous, count) as f32 * bounds.metre_per_count;
        self.previous = count;
        let way = match self.phase {
            Phase::ToLow => -1.0,
            Phase::ToHigh { .. } => 1.0,
            Phase::Back { .. } => -1.0,
            Phase::Settle { .. } => 0.0,
        };
        let before = self.lead - travelled;
        self.lead = if let Phase::Settle { middle, .. } = self.phase {
            between(count, middle) as f32 * bounds.metre_per_count
        } else {
            within(before + way * bounds.advance, bounds.lead)
        };
        // the jump of the reference to the middle is no speed
        let pace = if way == 0.0 { 0.0 } else { (self.lead - before) * bounds.rate };
        let wanted = bounds.stiffness * self.lead + bounds.damping * (pace - velocity);
        let wanted = within(wanted, bounds.force);
        let pushed = wanted.abs() >= PUSHED * bounds.force;
        if let Some((end, middle)) = self.judge(bounds, count, pushed) {
            return Progress::End(end, middle);
        }
        Progress::Force(within(bounds.low_pass.step(&mut self.filter, wanted), bounds.force))
    }

    /// Moves on to the next phase, or ends with a result and the count of the middle.
    fn judge(&mut self, bounds: &Bounds, count: u32, pushed: bool) -> Option<(Homed, u32)> {
        match self.phase {
            Phase::ToLow | Phase::ToHigh { .. } => {
                if between(self.began, count).unsigned_abs() > bounds.longest {
                    return Some((Homed::NoStop, count));
                }
                if !pushed || between(self.around, count).unsigned_abs() > bounds.rest {
                    (self.around, self.rested) = (count, 0);
                } else {
                    self.rested = self.rested.saturating_add(1);
                }
                if self.rested < bounds.pushed {
                    return None;
                }
                (self.began, self.around, self.rested) = (count, count, 0);
                let Phase::ToHigh { low } = self.phase else {
                    self.phase = Phase::ToHigh { low: count };
                    return None;
                };
                let apart = between(low, count);
                let stroke = apart as f32 * bounds.metre_per_count;
                let (least, most) = bounds.strokes;
                if !(stroke >= least && stroke <= most) {
                    return Some((Homed::Stroke { measured: stroke }, count));
                }
                self.phase = Phase::Back { middle: low.wrapping_add((apart / 2) as u32), stroke };
            }
            Phase::Back { middle, stroke } => {
                if between(middle, count) <= 0 {
                    self.phase = Phase::Settle { middle, stroke };
                }
            }
            Phase::Settle { middle, stroke } => {
                self.rested = self.rested.saturating_add(1);
                if self.rested >= bounds.settle {
                    return Some((Homed::Middle { stroke }, middle));
                }
            }
        }
        None
    }
}

/// Counts from one count to another.
fn between(from: u32, to: u32) -> i32 {
    to.wrapping_sub(from) as i32
}

/// A value within ±`limit`.
fn within(value: f32, limit: f32) -> f32 {
    if value > limit {
        limit
    } else if value < -limit {
        -limit
    } else {
        value
    }
}
