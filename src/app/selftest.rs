//! The self-test: half a second at rest with the amplifier off, then a push of the handle by a millimetre, judged by encoder,
//! accelerometer and load cell. Of signals that should agree in sign the odd one is wrong.

use super::{Telemetry, line};
use core::fmt;
use friction::{Dimension, Geometry};
use haptics::number::Text;
use haptics::{Channel, Device, ModeId};

/// Control periods at rest.
const PERIODS: u32 = 500;
/// Largest motion of the encoder at rest, counts: one either way.
const STILL: u32 = 2;
/// Smallest motion, counts.
const MOVED: u32 = 20;
/// Longest push, control periods. It normally ends long before.
const LONGEST: u32 = 40_000;
/// Smallest acceleration per newton of the push, 1/kg, on the default device: ten times the noise.
const ACCELERATES: f32 = 0.03;
/// Smallest reading of the load cell per newton of the push: ten times the noise.
const LOADS: f32 = 0.01;
/// The same for a held handle, where it reads most of the push.
const HELD: f32 = 0.3;

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

    fn si(&self, channel: &Channel) -> f32 {
        (self.mean() - channel.offset_code) * channel.unit_per_code
    }

    fn span(&self) -> u16 {
        self.highest - self.lowest
    }
}

/// Sums of the products of each signal with the force of the push.
#[derive(Debug, Clone, Copy, Default)]
struct Push {
    seen: u32,
    /// Forces of the last two periods: a sample shows the command of the previous period.
    forces: [f32; 2],
    velocity: f32,
    start: u32,
    travel: u32,
    /// [`ACCELERATES`] on this device.
    least: f32,
    /// Sum of N², and of the products with the accelerations of encoder and accelerometer and with the load.
    force: f32,
    encoder: f32,
    accel: f32,
    load: f32,
    largest: f32,
    fault: bool,
}

/// Progress of the test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Progress {
    /// More periods are needed.
    More,
    /// Rest is judged and a push is safe: request it.
    Push,
    /// [`SelfTest::checks`] is complete.
    Done,
}

/// A running self-test.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SelfTest {
    seen: u32,
    first: Option<Telemetry>,
    last_ticks: u32,
    /// Largest deviation of two samples from the period, ticks, except across missed periods.
    unevenness: u32,
    last_step: u32,
    travel: u32,
    load: Codes,
    accel: Codes,
    force_on: u32,
    push: Option<Push>,
}

/// Result of a check.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Check {
    pub passed: bool,
    pub finding: Finding,
}

/// One line of the result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Finding {
    Loop { unevenness_us: f32 },
    Encoder { counts: u32, sign: Sign },
    LoadCell { newton: f32, span: u16, sign: Sign },
    Accelerometer { metre_per_second_squared: f32, span: u16, sign: Sign },
    Amplifier { periods_on: u32, push: Pushed },
}

/// Sign of a signal relative to the push.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sign {
    /// No push to judge it by.
    NotJudged,
    /// In the direction of the push.
    Right,
    /// Against the other signals.
    Wrong,
    /// No signal.
    Silent,
}

/// Result of the push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pushed {
    /// No push: a check at rest failed.
    NotTried,
    /// Motion of this size with this force.
    Moved { metre: f32, newton: f32 },
    /// Motion in the wrong direction.
    Backwards,
    /// The load cell measured it and nothing moved.
    Held { newton: f32 },
    /// No sensor measured it.
    Nothing { newton: f32 },
    /// The accelerometer measured it, the encoder did not.
    Unseen { newton: f32 },
    /// Ended by a fault.
    Fault,
}

impl Check {
    /// Its line, in the units of this geometry.
    pub(super) fn on(&self, geometry: Geometry) -> impl fmt::Display {
        OnDevice(*self, geometry)
    }
}

/// A check in the units of a device.
struct OnDevice(Check, Geometry);

impl fmt::Display for OnDevice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(check, geometry) = self;
        let n = Dimension::FORCE.unit(*geometry);
        let (scale, way) = line::travel(*geometry);
        f.write_str(if check.passed { "pass  " } else { "FAIL  " })?;
        let advice = match check.finding {
            Finding::Loop { unevenness_us } => {
                write!(f, "loop: samples within {:.2} us of the period", Text(unevenness_us))?;
                "; the processor misses its steps"
            }
            Finding::Encoder { counts, sign } => {
                write!(f, "encoder: moved {counts} counts at rest")?;
                sign.write("counts", f)?;
                match sign {
                    Sign::Wrong => "; exchange its channels A and B",
                    Sign::Silent => "; check its cable and supply",
                    _ => "; hands off and repeat, or check shield and supply of the encoder",
                }
            }
            Finding::LoadCell { newton, span, sign } => {
                write!(f, "load cell: {:.3} {n} at rest, noise over {span} codes", Text(newton))?;
                sign.write("reads", f)?;
                match sign {
                    Sign::Wrong => "; exchange its two signal wires",
                    _ if span == 0 => "; no noise at all: check the connection",
                    _ => "; hands off, then `calibrate` or check its cable",
                }
            }
            Finding::Accelerometer { metre_per_second_squared, span, sign } => {
                let a = Text(metre_per_second_squared);
                let unit = Dimension::ACCELERATION.unit(*geometry);
                write!(f, "accelerometer: {a:.2} {unit} at rest, noise over {span} codes")?;
                sign.write("reads", f)?;
                match sign {
                    _ if span == 0 => "; no noise at all: check the connection",
                    Sign::Wrong => "; reverse its orientation",
                    Sign::Silent => "; check its cable and its mount on the handle",
                    _ => "; above gravity, or 30 % off the encoder: check its cable, `calibrate`",
                }
            }
            Finding::Amplifier { periods_on, push } => match push {
                Pushed::NotTried => {
                    write!(f, "amplifier: no push tried ({periods_on} periods on at rest)")?;
                    "; repair the other failures, hands off, and repeat"
                }
                Pushed::Moved { metre, newton } => {
                    let (newton, moved) = (Text(newton), Text(scale * metre));
                    write!(f, "amplifier: {newton:.2} {n} moved the handle by {moved:.2} {way}, off again")?;
                    "; more acceleration than this force can give: check its gain"
                }
                Pushed::Backwards => "amplifier: pushes in the wrong direction; exchange the motor wires",
                Pushed::Held { newton } => {
                    write!(f, "amplifier: {:.2} {n} at the load cell, no motion", Text(newton))?;
                    "; handle held or blocked: release it and repeat"
                }
                Pushed::Nothing { newton } => {
                    write!(f, "amplifier: up to {:.2} {n} without any response", Text(newton))?;
                    "; check enable, supply and motor wires, or release a blocked handle"
                }
                Pushed::Unseen { newton } => {
                    write!(f, "amplifier: {:.2} {n} at the accelerometer, off again", Text(newton))?;
                    ""
                }
                Pushed::Fault => "amplifier: a fault ended the push; see `fault`",
            },
        };
        let unsaid =
            matches!(check.finding, Finding::Amplifier { push: Pushed::Backwards | Pushed::Fault, .. });
        if check.passed && !unsaid { Ok(()) } else { f.write_str(advice) }
    }
}

impl Sign {
    fn of(sum: f32, least: f32, right: f32) -> Self {
        if !(sum.abs() >= least) {
            Self::Silent
        } else if sum * right > 0.0 {
            Self::Right
        } else {
            Self::Wrong
        }
    }

    fn write(self, verb: &str, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotJudged => Ok(()),
            Self::Right => write!(f, ", {verb} with the push"),
            Self::Wrong => write!(f, ", {verb} against the push"),
            Self::Silent => write!(f, ", {verb} no push"),
        }
    }
}

impl SelfTest {
    /// One control period.
    pub fn take(&mut self, t: &Telemetry, device: &Device) -> Progress {
        if let Some(push) = &mut self.push {
            return push.take(t, device, &self.load, &self.accel);
        }
        let first = *self.first.get_or_insert(*t);
        if self.seen > 0 && t.step.wrapping_sub(self.last_step) == 1 {
            let elapsed = t.inputs.sample_ticks.wrapping_sub(self.last_ticks);
            self.unevenness = self.unevenness.max(elapsed.abs_diff(device.period_ticks()));
        }
        self.last_step = t.step;
        self.last_ticks = t.inputs.sample_ticks;
        let moved = (t.inputs.count.wrapping_sub(first.inputs.count) as i32).unsigned_abs();
        self.travel = self.travel.max(moved);
        self.load.add(t.inputs.load_code, self.seen == 0);
        self.accel.add(t.inputs.accel_code, self.seen == 0);
        self.force_on += u32::from(t.outputs.amplifier || t.outputs.mode == ModeId::Rendering);
        self.seen += 1;
        if self.seen < PERIODS {
            return Progress::More;
        }
        let rests = self.travel <= STILL
            && self.force_on == 0
            && self.load.si(&device.load).abs() <= device.rest_force;
        if rests {
            self.push = Some(Push {
                start: t.inputs.count,
                least: ACCELERATES / device.inertia(1.0),
                ..Push::default()
            });
            Progress::Push
        } else {
            Progress::Done
        }
    }

    /// Results, once [`Self::take`] returned `Done`.
    pub fn checks(&self, device: &Device) -> [Check; 5] {
        let unevenness_us = self.unevenness as f32 / device.tick_hz as f32 * 1e6;
        let (newton, a) = (self.load.si(&device.load), self.accel.si(&device.accel));
        let (load_span, accel_span) = (self.load.span(), self.accel.span());
        let check = |passed, finding| Check { passed, finding };
        let push = self.push.unwrap_or_default();
        let [encoder, accel, load] = push.signs();
        let pushed = if self.push.is_some() { push.judge(device) } else { Pushed::NotTried };
        let agrees = |sign| matches!(sign, Sign::NotJudged | Sign::Right);
        // the same motion from two sensors
        let same = encoder == Sign::NotJudged
            || accel != Sign::Right
            || (0.7..1.3).contains(&(push.accel.abs() / push.encoder.abs().max(1e-9)));
        // gravity, and half of it again; on an axis it is no acceleration
        let tilted = if device.geometry == Geometry::Linear { 15.0 } else { 0.03 * device.acceleration_max };
        let light = push.force < 0.4 * device.mass * push.encoder.abs();
        [
            check(unevenness_us < 5.0, Finding::Loop { unevenness_us }),
            check(
                self.travel <= STILL && agrees(encoder),
                Finding::Encoder { counts: self.travel, sign: encoder },
            ),
            check(
                // no load, or too little to measure: no sign to judge
                newton.abs() <= device.rest_force && load_span > 0 && load != Sign::Wrong,
                Finding::LoadCell { newton, span: load_span, sign: load },
            ),
            check(
                a.abs() <= tilted && accel_span > 0 && agrees(accel) && same,
                Finding::Accelerometer { metre_per_second_squared: a, span: accel_span, sign: accel },
            ),
            check(
                self.force_on == 0
                    && matches!(pushed, Pushed::Moved { .. } | Pushed::Unseen { .. })
                    && !light,
                Finding::Amplifier { periods_on: self.force_on, push: pushed },
            ),
        ]
    }
}

impl Push {
    fn take(&mut self, t: &Telemetry, device: &Device, load: &Codes, accel: &Codes) -> Progress {
        self.seen += 1;
        let force = self.forces[1];
        self.forces = [t.outputs.force, self.forces[0]];
        let unit = |code: u16, rest: &Codes, channel: &Channel| {
            (f32::from(code) - rest.mean()) * channel.unit_per_code
        };
        self.force += force * force;
        self.encoder += force * (t.outputs.velocity - self.velocity) / device.period;
        self.accel += force * unit(t.inputs.accel_code, accel, &device.accel);
        self.load += force * unit(t.inputs.load_code, load, &device.load);
        self.velocity = t.outputs.velocity;
        self.largest = self.largest.max(force.abs());
        self.travel = self.travel.max((t.inputs.count.wrapping_sub(self.start) as i32).unsigned_abs());
        self.fault = t.outputs.mode == ModeId::Fault;
        let over = self.largest > 0.0 && t.outputs.mode == ModeId::Idle;
        if over || self.fault || self.seen > LONGEST { Progress::Done } else { Progress::More }
    }

    /// Whether the encoder shows motion.
    fn moved(&self) -> bool {
        !self.fault && self.travel >= MOVED
    }

    /// Whether the handle moved without the encoder. The loop may have found it first.
    fn unseen(&self) -> bool {
        self.travel <= STILL && self.accel.abs() > self.least * self.force && self.force > 0.0
    }

    /// Direction of the motion, by majority of the sensors.
    fn way(&self) -> f32 {
        let vote = |sum: f32, least: f32| if sum.abs() < least * self.force { 0.0 } else { sum.signum() };
        let votes = vote(self.encoder, self.least) + vote(self.accel, self.least) + vote(self.load, LOADS);
        if votes < 0.0 { -1.0 } else { 1.0 }
    }

    /// Encoder, accelerometer, load cell.
    fn signs(&self) -> [Sign; 3] {
        if self.unseen() {
            return [Sign::Silent, Sign::NotJudged, Sign::NotJudged];
        }
        if !self.moved() {
            return [Sign::NotJudged; 3];
        }
        let way = self.way();
        let of = |sum, least| Sign::of(sum, least * self.force, way);
        [of(self.encoder, self.least), of(self.accel, self.least), of(self.load, LOADS)]
    }

    fn judge(&self, device: &Device) -> Pushed {
        let newton = self.largest;
        if self.unseen() {
            Pushed::Unseen { newton }
        } else if self.fault {
            Pushed::Fault
        } else if self.moved() && self.way() < 0.0 {
            Pushed::Backwards
        } else if self.moved() {
            Pushed::Moved { metre: self.travel as f32 * device.metre_per_count, newton }
        } else if self.load.abs() > HELD * self.force {
            Pushed::Held { newton }
        } else {
            Pushed::Nothing { newton }
        }
    }
}
