//! An encoder that is silent while force and acceleration say motion: a broken cable, a slipped disc, a dead channel.
//!
//! While the count stays within one of where it stopped, the accelerometer and the net force on the device (command
//! less what the load cell passes on) are summed up. A handle that really rests gives neither; a handle that moves
//! unseen gives both, with the same sign: v = ∫a dt and m·v = ∫(F − F_load) dt − what friction takes.
//!
//! **What it finds**: a change of speed of [`SPEED`] within some [`MEMORY_S`], of which the net force explains at
//! least [`SHARE`]. The full force of the thesis's actuator gives that in 4 ms and 0.1 mm; the least constant
//! acceleration that does is 0.5 m/s². An unseen motion at constant speed gives no evidence and is not found: it
//! changes no force of the loop, either.
//!
//! **What it bears**: an accelerometer or load cell with an offset (the means are tracked over [`DRIFT_S`]), noise (the
//! thesis's is 2 mm/s and 0.4 mN·s), motion too slow for edges, impacts (edges start it afresh), a slow load on a
//! stuck block (no acceleration).

use crate::{Device, Inputs};

/// Change of speed without a count that is a fault, m/s.
const SPEED: f32 = 0.05;
/// Share of the momentum that the net force must explain.
const SHARE: f32 = 0.25;
/// What was summed up is forgotten with this time constant, s.
const MEMORY_S: f32 = 0.1;
/// Offsets are followed with this time constant, s: slow against every motion that is accelerated.
const DRIFT_S: f32 = 4.0;
/// Samples that must agree: a blow is felt before the handle has moved, and a single wild sample is not motion.
const SAMPLES: u32 = 3;

/// The bounds in what a step sums up, codes and samples: a step neither divides nor converts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    /// Share of the sums kept in a period.
    keep: f32,
    /// Share of an offset learned in a period.
    drift: f32,
    /// Codes of the load cell in a newton.
    code_per_newton: f32,
    /// [`SPEED`], accelerometer codes · periods.
    speed: f32,
    /// Load cell codes that must go with a code of the accelerometer.
    share: f32,
    /// Distance from where the speed leads that no acceleration explains, m: twice what the largest one moves in a
    /// period, for the lag of the velocity.
    pub jump: f32,
}

impl Bounds {
    pub fn new(device: &Device) -> Self {
        Self {
            keep: 1.0 - device.period / MEMORY_S,
            drift: device.period / DRIFT_S,
            code_per_newton: 1.0 / device.load.unit_per_code,
            speed: SPEED / (device.period * device.accel.unit_per_code),
            jump: 2.0 * device.acceleration_max * device.period * device.period
                + 4.0 * device.metre_per_count,
            share: SHARE * device.mass * device.accel.unit_per_code / device.load.unit_per_code,
        }
    }
}

/// A signal without its offset, summed up since the last count, codes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sum {
    offset: f32,
    sum: f32,
}

impl Sum {
    #[inline]
    fn learn(&mut self, value: f32, learn: f32) -> f32 {
        self.offset += learn * (value - self.offset);
        value - self.offset
    }
}

/// What is remembered of the silence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Silence {
    /// Count around which there is silence.
    around: u32,
    /// Samples in a row that said motion, saturating.
    samples: u32,
    /// Share of an offset learned with a sample: all with the first, then less and less (2/n) down to that of
    /// [`DRIFT_S`].
    learn: f32,
    acceleration: Sum,
    force: Sum,
}

impl Default for Silence {
    fn default() -> Self {
        Self { around: 0, samples: 0, learn: 1.0, acceleration: Sum::default(), force: Sum::default() }
    }
}

impl Silence {
    /// One sample; `command` is the force of the step before, N. True while the handle moves unseen.
    #[inline]
    pub fn sample(&mut self, bounds: &Bounds, inputs: &Inputs, command: f32) -> bool {
        let acceleration = f32::from(inputs.accel_code);
        let force = command * bounds.code_per_newton - f32::from(inputs.load_code);
        let learn = self.learn;
        let acceleration = self.acceleration.learn(acceleration, learn);
        let force = self.force.learn(force, learn);
        if learn > bounds.drift {
            self.learn = learn - 0.5 * learn * learn;
        }
        // one count to and fro is what a dead channel of the two gives, and noise on an edge
        if inputs.count.wrapping_sub(self.around).wrapping_add(1) > 2 {
            self.around = inputs.count;
            self.samples = 0;
            (self.acceleration.sum, self.force.sum) = (0.0, 0.0);
            return false;
        }
        self.acceleration.sum = bounds.keep * self.acceleration.sum + acceleration;
        self.force.sum = bounds.keep * self.force.sum + force;
        self.samples = if self.moves(bounds) { self.samples.saturating_add(1) } else { 0 };
        self.samples >= SAMPLES
    }

    /// Forgets what was summed up, not the offsets.
    pub fn afresh(&mut self) {
        self.samples = 0;
        (self.acceleration.sum, self.force.sum) = (0.0, 0.0);
    }

    /// Speed that the accelerometer says and no count, as a share of what would be a fault.
    pub fn share(&self, bounds: &Bounds) -> f32 {
        self.acceleration.sum.abs() / bounds.speed
    }

    /// The handle moves, for all that acceleration and force say.
    #[inline]
    pub fn moves(&self, bounds: &Bounds) -> bool {
        let (speed, momentum) = (self.acceleration.sum, self.force.sum);
        speed.abs() > bounds.speed
            && if speed > 0.0 { momentum >= bounds.share * speed } else { momentum <= bounds.share * speed }
    }
}
