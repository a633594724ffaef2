//! The self-test: half a second at rest, amplifier off.

use super::Telemetry;
use core::fmt;
use haptics::{Device, ModeId};

/// Control periods looked at.
const PERIODS: u32 = 500;
/// Counts the encoder may move at rest: one either way.
const STILL: u32 = 2;

/// Mean and spread of raw codes.
#[derive(Debug, Clone, Copy, Default)]
struct Codes {
    sum: u32,
    lowest: u16,
    highest: u16,
}

impl Codes {
    fn add(&mut self, code: u16, first: bool) {
        self.sum = self.sum.wrapping_add(u32::from(code));
        self.lowest = if first { code } else { self.lowest.min(code) };
        self.highest = if first { code } else { self.highest.max(code) };
    }

    fn mean(&self) -> f32 {
        self.sum as f32 / PERIODS as f32
    }
}

/// A self-test that runs.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SelfTest {
    seen: u32,
    first: Option<Telemetry>,
    last_ticks: u32,
    /// Longest distance of two samples from the period, ticks; not across periods the tasks did not see.
    unevenness: u32,
    lost: u32,
    last_step: u32,
    travel: u32,
    load: Codes,
    accel: Codes,
    force_on: u32,
}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Check {
    pub passed: bool,
    pub finding: Finding,
}

/// One line of the result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Finding {
    Loop { unevenness_us: f32 },
    Encoder { counts: u32 },
    LoadCell { newton: f32, span: u16 },
    Accelerometer { metre_per_second_squared: f32, span: u16 },
    Amplifier { periods_on: u32 },
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.passed { "pass  " } else { "FAIL  " })?;
        let advice = match self.finding {
            Finding::Loop { unevenness_us } => {
                write!(f, "loop: samples within {unevenness_us:.2} us of the period")?;
                "; something keeps the processor from its step"
            }
            Finding::Encoder { counts } => {
                write!(f, "encoder: moved {counts} counts at rest")?;
                "; hands off and repeat, else check shield and supply of the encoder"
            }
            Finding::LoadCell { newton, span } => {
                write!(f, "load cell: {newton:.3} N at rest, noise over {span} codes")?;
                if span == 0 {
                    "; no noise at all: is it connected?"
                } else {
                    "; hands off, then tare or check its cable"
                }
            }
            Finding::Accelerometer { metre_per_second_squared, span } => {
                write!(
                    f,
                    "accelerometer: {metre_per_second_squared:.2} m/s2 at rest, noise over {span} codes"
                )?;
                if span == 0 {
                    "; no noise at all: is it connected?"
                } else {
                    "; more than gravity: check its cable"
                }
            }
            Finding::Amplifier { periods_on } => {
                write!(f, "amplifier: off, force zero ({periods_on} periods on)")?;
                "; something drives the handle: stop it first"
            }
        };
        if self.passed { Ok(()) } else { f.write_str(advice) }
    }
}

impl SelfTest {
    /// One control period; true when enough were seen.
    pub fn take(&mut self, t: &Telemetry, device: &Device) -> bool {
        let first = *self.first.get_or_insert(*t);
        if self.seen > 0 {
            if t.step.wrapping_sub(self.last_step) == 1 {
                let elapsed = t.inputs.sample_ticks.wrapping_sub(self.last_ticks);
                self.unevenness = self.unevenness.max(elapsed.abs_diff(device.period_ticks()));
            } else {
                self.lost += 1;
            }
        }
        self.last_step = t.step;
        self.last_ticks = t.inputs.sample_ticks;
        let moved = (t.inputs.count.wrapping_sub(first.inputs.count) as i32).unsigned_abs();
        self.travel = self.travel.max(moved);
        self.load.add(t.inputs.load_code, self.seen == 0);
        self.accel.add(t.inputs.accel_code, self.seen == 0);
        self.force_on += u32::from(t.outputs.amplifier || t.outputs.mode == ModeId::Rendering);
        self.seen += 1;
        self.seen >= PERIODS
    }

    /// The verdicts, when [`Self::take`] has said that enough was seen.
    pub fn checks(&self, device: &Device) -> [Check; 5] {
        let unevenness_us = self.unevenness as f32 / device.tick_hz as f32 * 1e6;
        let load = (self.load.mean() - device.load.offset_code) * device.load.unit_per_code;
        let accel = (self.accel.mean() - device.accel.offset_code) * device.accel.unit_per_code;
        let span = |codes: &Codes| codes.highest - codes.lowest;
        let (load_span, accel_span) = (span(&self.load), span(&self.accel));
        let check = |passed, finding| Check { passed, finding };
        [
            check(unevenness_us < 5.0, Finding::Loop { unevenness_us }),
            check(self.travel <= STILL, Finding::Encoder { counts: self.travel }),
            check(
                load.abs() <= device.rest_force && load_span > 0,
                Finding::LoadCell { newton: load, span: load_span },
            ),
            check(
                accel.abs() <= 15.0 && accel_span > 0,
                Finding::Accelerometer { metre_per_second_squared: accel, span: accel_span },
            ),
            check(self.force_on == 0, Finding::Amplifier { periods_on: self.force_on }),
        ]
    }
}
