//! Slow checks of the force path, for a task below the control step: whether load cell and motion agree with the commanded
//! force, whether the sensors still measure, and how hot the motor is.
//!
//! The control step withdraws force for what one sample shows ([`crate::FaultKind`]). What follows needs some milliseconds of
//! evidence, so it costs the step nothing.
//!
//! **Balance of forces.** Motor, load cell and inertia balance up to the friction of the device:
//!
//! ```text
//! unexplained = F_commanded − F_load cell − m·a − b·v
//! ```
//!
//! a comes once from the encoder and once from the accelerometer. The fault needs both to exceed
//! [`Limits::unexplained_force`] with the same sign, so that one wrong sensor of the motion is not a wrong force. A
//! command wire that broke, an amplifier without supply, a load cell that floats: each leaves a force unexplained. At a
//! stop of the stroke the stop takes any force, so nothing is judged there; with the stops unknown the handle must also
//! travel 4 mm, which no stop lets it.
//!
//! **Sensors.** A converter whose code does not change at all for 0.5 s measures nothing: 16 summed conversions of a
//! live signal have noise. An accelerometer that floats has noise, but does not follow the encoder: over blocks of 20 ms it
//! must show at least half of the energy of the second differences of the speed.
//!
//! **Heat.** I²t from the command: the square of the force, as a share of that of [`Limits::continuous_force`], through the
//! thermal time constant of the motor.

use crate::{Accepted, Device, FaultKind, Inputs, ModeId, Outputs, Reason, Refused, number};
use friction::Dimension;

/// Time constant of the balance, s.
const BALANCE_S: f32 = 0.01;
/// Time for which a force must stay unexplained, s. A blow on the handle is shorter.
const UNEXPLAINED_S: f32 = 4e-3;
/// Travel with a force unexplained that no stop lets a handle make, m. Lengths and speeds here are those of the default device.
const TRAVEL: f32 = 4e-3;
/// Distance from a stop within which it may touch, m: the tolerance of the stroke, 3 %, and half a millimetre.
const STOP_ZONE: f32 = 1.5e-3;
/// Largest force that enters the balance, as a multiple of the actuator's: a blow counts little.
const BLOW: f32 = 1.5;
/// Time without any change of a code that is a fault, s.
const FROZEN_S: f32 = 0.5;
/// Length of a block of the comparison of the accelerometer with the encoder, ms.
const BLOCK_MS: u32 = 20;
/// Share of the sums of that comparison kept from block to block: 0.4 s.
const KEEP: f32 = 0.95;
/// Blocks of motion that must disagree.
const BLOCKS: u32 = 10;
/// Smallest rms second difference of the speed that is judged, m/s: three times the noise of the accelerometer of
/// [thesis, table 3-2].
const CHANGE: f32 = 4e-3;
/// Acceleration of an impact, m/s². Samples cannot follow it, so its blocks are left out.
const IMPACT: f32 = 40.0;
/// Share of the energy that the accelerometer may leave unexplained.
const SHARE: f32 = 0.5;

/// Limits of the slow checks that depend on the device. They apply from the next period on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Force that neither load cell nor motion explains, N: more than the friction of the device itself.
    pub unexplained_force: f32,
    /// Force that the motor holds for ever, N.
    pub continuous_force: f32,
    /// Thermal time constant of the motor's winding, s.
    pub heating_s: f32,
}

/// One of the [`Limits`], as people set it.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    /// Name as typed.
    pub name: &'static str,
    /// Dimension of the value.
    pub dimension: Dimension,
    /// Meaning in a few words.
    pub what: &'static str,
    /// Place of the value.
    pub of: fn(&mut Limits) -> &mut f32,
}

impl Limits {
    /// Every limit.
    pub const ALL: &'static [Limit; 3] = &[
        Limit {
            name: "unexplained_force",
            dimension: Dimension::FORCE,
            what: "largest force that load cell and motion leave unexplained",
            of: |limits| &mut limits.unexplained_force,
        },
        Limit {
            name: "continuous_force",
            dimension: Dimension::FORCE,
            what: "force that the motor holds for ever",
            of: |limits| &mut limits.continuous_force,
        },
        Limit {
            name: "heating",
            dimension: Dimension::TIME,
            what: "thermal time constant of the motor",
            of: |limits| &mut limits.heating_s,
        },
    ];

    /// Checks each against the actuator.
    ///
    /// # Errors
    /// The first one out of range, or NaN.
    pub fn validate(&self, device: &Device) -> Result<(), Refused> {
        let most = device.force_max;
        // against the rounding of a product
        let at_least = |x: f32| number::four_digits(x * (1.0 - 1e-6), true);
        let ranges = [
            (at_least(0.1 * most), most, "above the friction of the device, below the actuator's force"),
            (at_least(0.05 * most), most, "up to the actuator's force"),
            (1.0, 3_600.0, ""),
        ];
        let mut limits = *self;
        for (limit, (low, high, words)) in Self::ALL.iter().zip(ranges) {
            let value = *(limit.of)(&mut limits);
            if !(value >= low && value <= high) {
                return Err(Refused {
                    effect: None,
                    parameter: limit.name,
                    value,
                    accepted: Accepted::Between(low, high),
                    why: Reason::of(limit.dimension, words),
                });
            }
        }
        Ok(())
    }

    /// Those of a device: the same shares of its largest force.
    #[must_use]
    pub fn of(device: &Device) -> Self {
        let own = Self::default();
        Self {
            unexplained_force: device.force(own.unexplained_force),
            continuous_force: device.force(own.continuous_force),
            ..own
        }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            // the rig of [thesis, table 3-1] has a friction of 1.04 N
            unexplained_force: 3.5,
            // *assumed*: [thesis, table 3-1] rates 9.48 N at a room temperature it does not print; 84 % leaves 30 % of the heat
            continuous_force: 8.0,
            // *assumed*: that of windings of motors of this size
            heating_s: 60.0,
        }
    }
}

/// State of the slow checks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Monitor {
    /// Number, force, velocity and count of the last step.
    last: Option<(u32, f32, f32, u32)>,
    sum: Sum,
    balance: Balance,
    load: Frozen,
    accel: Frozen,
    follow: Follow,
    /// Heat of the motor, as a share of what it bears.
    heat: f32,
}

/// Control periods on the way to a millisecond: the checks are the same at every rate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sum {
    seconds: f32,
    /// Impulses of the command, of the load cell, and change of speed by the accelerometer.
    commanded: f32,
    squared: f32,
    load: f32,
    accel: f32,
    speed: f32,
    travel: f32,
}

impl Monitor {
    /// One control period: `step` is its number. The reason why force must be withdrawn, if any; the caller judges it only
    /// while force is on.
    pub fn sample(
        &mut self,
        device: &Device,
        limits: &Limits,
        step: u32,
        inputs: &Inputs,
        outputs: &Outputs,
    ) -> Option<FaultKind> {
        let on = outputs.amplifier;
        let last = self.last.replace((step, outputs.force, outputs.velocity, inputs.count));
        let frozen = self.load.sample(inputs.load_code, device.period)
            | self.accel.sample(inputs.accel_code, device.period);
        let Some((_, force, velocity, count)) = last.filter(|(before, ..)| step.wrapping_sub(*before) == 1)
        else {
            // periods were missed: what they had is unknown
            (self.sum, self.balance) = (Sum::default(), Balance::default());
            self.follow.skip();
            return None;
        };
        let period = device.period;
        let sum = &mut self.sum;
        sum.seconds += period;
        sum.commanded += force * period;
        sum.squared += force * force * period;
        sum.load += device.load.to_si(inputs.load_code) * period;
        sum.accel += device.accel.to_si(inputs.accel_code) * period;
        sum.speed += outputs.velocity - velocity;
        sum.travel += inputs.count.wrapping_sub(count) as i32 as f32 * device.metre_per_count;
        if sum.seconds < 0.999e-3 {
            return None;
        }
        let sum = core::mem::take(sum);
        let bearable = limits.continuous_force * limits.continuous_force;
        self.heat += (sum.squared / bearable - self.heat * sum.seconds) / limits.heating_s;
        // a search leans on the stops, and hits them
        let judged = outputs.mode != ModeId::Homing;
        let follows = !judged || self.follow.sample(device, &sum);
        if !on || !judged {
            self.balance = Balance::default();
        } else if self.balance.sample(device, limits, &sum, outputs) {
            return Some(FaultKind::ForceContradicted);
        }
        if self.heat > 1.0 {
            Some(FaultKind::MotorHot)
        } else if frozen || !follows {
            Some(FaultKind::SensorDead)
        } else {
            None
        }
    }

    /// Heat of the motor, as a share of what it bears.
    #[must_use]
    pub fn heat(&self) -> f32 {
        self.heat
    }
}

/// The balance of forces.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Balance {
    /// Unexplained force, N: by the encoder, by the accelerometer.
    unexplained: [f32; 2],
    seconds: f32,
    travel: f32,
}

impl Balance {
    fn sample(&mut self, device: &Device, limits: &Limits, sum: &Sum, outputs: &Outputs) -> bool {
        let at_stop = outputs.position.abs() > 0.5 * device.stroke - device.length(STOP_ZONE);
        if outputs.referenced && at_stop {
            *self = Self::default();
            return false;
        }
        let learn = sum.seconds / (BALANCE_S + sum.seconds);
        let static_part = sum.commanded - sum.load - device.damping * sum.travel;
        let blow = BLOW * device.force_max;
        for (unexplained, change) in self.unexplained.iter_mut().zip([sum.speed, sum.accel]) {
            let now = (static_part - device.mass * change) / sum.seconds;
            let now = if now > blow {
                blow
            } else if now < -blow {
                -blow
            } else {
                now
            };
            // NaN cannot be: codes, a finite force and a finite velocity
            *unexplained += learn * (now - *unexplained);
        }
        let [by_encoder, by_accel] = self.unexplained;
        let limit = limits.unexplained_force;
        if (by_encoder > limit && by_accel > limit) || (by_encoder < -limit && by_accel < -limit) {
            self.seconds += sum.seconds;
            self.travel += sum.travel;
        } else {
            (self.seconds, self.travel) = (0.0, 0.0);
        }
        self.seconds >= UNEXPLAINED_S && (outputs.referenced || self.travel.abs() > device.length(TRAVEL))
    }
}

/// A code that does not change.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Frozen {
    code: u16,
    seconds: f32,
}

impl Frozen {
    fn sample(&mut self, code: u16, period: f32) -> bool {
        self.seconds = if code == self.code { self.seconds + period } else { 0.0 };
        self.code = code;
        self.seconds > FROZEN_S
    }
}

/// Whether the accelerometer follows the encoder: mean speeds of three blocks, whose second difference is free of the offset
/// of the accelerometer. The encoder's come from its counts, which need no estimate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Follow {
    milliseconds: u32,
    seconds: f32,
    /// Speed by the accelerometer since the last pause, m/s.
    speed: f32,
    /// Path in this block by the encoder and by the accelerometer, m.
    path: [f32; 2],
    /// Mean speeds of the two blocks before, m/s.
    before: [Option<[f32; 2]>; 2],
    impact: bool,
    /// Mean squares of the encoder's second differences, and of what the accelerometer leaves of them.
    moved: f32,
    missed: f32,
    /// Consecutive blocks that disagree.
    blocks: u32,
}

impl Follow {
    fn skip(&mut self) {
        *self = Self { moved: self.moved, missed: self.missed, blocks: self.blocks, ..Self::default() };
    }

    fn sample(&mut self, device: &Device, sum: &Sum) -> bool {
        let impact = device.speed(IMPACT) * sum.seconds;
        self.impact |= sum.speed.abs() > impact || sum.accel.abs() > impact;
        self.path[0] += sum.travel;
        self.path[1] += (self.speed + 0.5 * sum.accel) * sum.seconds;
        self.speed += sum.accel;
        self.seconds += sum.seconds;
        self.milliseconds += 1;
        if self.milliseconds < BLOCK_MS {
            return self.blocks < BLOCKS;
        }
        if self.impact {
            self.skip();
            return self.blocks < BLOCKS;
        }
        let mean = self.path.map(|path| path / self.seconds);
        if let [Some(a), Some(b)] = self.before {
            let [moved, shown] = core::array::from_fn(|k| mean[k] - 2.0 * b[k] + a[k]);
            self.moved = KEEP * self.moved + (1.0 - KEEP) * moved * moved;
            self.missed = KEEP * self.missed + (1.0 - KEEP) * (moved - shown) * (moved - shown);
            let change = device.speed(CHANGE);
            let disagree = self.moved > change * change && self.missed > SHARE * self.moved;
            self.blocks = if disagree { self.blocks + 1 } else { 0 };
        }
        self.before = [self.before[1], Some(mean)];
        (self.milliseconds, self.seconds, self.path) = (0, 0.0, [0.0; 2]);
        self.blocks < BLOCKS
    }
}
