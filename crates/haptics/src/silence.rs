//! Detection of a silent encoder: force and acceleration show motion, the count does not (broken cable, slipped disc, dead
//! channel).
//!
//! While the count stays within one of its last value, the accelerometer and the net force on the device (command less load
//! cell) are integrated. A handle at rest gives neither sum. A handle that moves gives both, with the same sign: v = ∫a dt
//! and m·v = ∫(F − F_load) dt less the impulse of friction.
//!
//! **Detected**: a change of speed of [`SPEED`] within about [`MEMORY_S`] of which the net force explains at least
//! [`SHARE`]. The full force of the actuator of [thesis, table 3-1] gives that in 4 ms and 0.1 mm; the smallest sufficient
//! constant acceleration is 0.5 m/s². A motion at constant speed gives no evidence and is not detected; it changes no force
//! of the loop.
//!
//! **Tolerated**: offsets of accelerometer and load cell (tracked over [`DRIFT_S`]), noise (2 mm/s and 0.4 mN·s for
//! [thesis, table 3-2]), motion too slow for edges, impacts (edges restart the sums), a slow load on a stuck block (no
//! acceleration).

use crate::{Device, Inputs};

/// Change of speed without a count that is a fault, m/s, on the default device.
const SPEED: f32 = 0.05;
/// Share of the momentum that the net force must explain.
const SHARE: f32 = 0.25;
/// Time constant of forgetting the sums, s.
const MEMORY_S: f32 = 0.1;
/// Time constant of the offsets, s: slow against every accelerated motion.
const DRIFT_S: f32 = 4.0;
/// Consecutive samples that must agree: a blow is measured before the handle moves, and a single outlier is no motion.
const SAMPLES: u32 = 3;

/// Bounds in the units of the sums, codes and samples, so that a step neither divides nor converts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    /// Share of the sums kept per period.
    keep: f32,
    /// Share of an offset learned per period.
    drift: f32,
    /// Codes of the load cell per newton.
    code_per_newton: f32,
    /// [`SPEED`], accelerometer codes · periods.
    speed: f32,
    /// Load cell codes that must accompany a code of the accelerometer. Negative if one of them is reversed.
    share: f32,
    /// Largest deviation from the predicted position that an acceleration explains, m. Twice the displacement of the largest
    /// acceleration in a period, for the lag of the velocity.
    pub jump: f32,
}

impl Bounds {
    pub fn new(device: &Device) -> Self {
        Self {
            keep: 1.0 - device.period / MEMORY_S,
            drift: device.period / DRIFT_S,
            code_per_newton: 1.0 / device.load.unit_per_code,
            speed: device.speed(SPEED) / (device.period * device.accel.unit_per_code.abs()),
            jump: 2.0 * device.acceleration_max * device.period * device.period
                + 4.0 * device.metre_per_count,
            share: SHARE * device.mass * device.accel.unit_per_code / device.load.unit_per_code,
        }
    }
}

/// Sum of a signal without its offset since the last count, codes.
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

/// State of the detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Silence {
    /// Count at which the encoder became silent.
    around: u32,
    /// Consecutive samples that showed motion, saturating.
    samples: u32,
    /// Share of an offset learned with a sample: all with the first, then 2/n, down to that of [`DRIFT_S`].
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
    /// One sample. `command` is the force of the previous step, N. True while the handle moves without counts.
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
        // one count back and forth comes from a dead channel, or from noise at an edge
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

    /// Clears the sums and keeps the offsets.
    pub fn afresh(&mut self) {
        self.samples = 0;
        (self.acceleration.sum, self.force.sum) = (0.0, 0.0);
    }

    /// Change of speed that only the accelerometer shows, as a share of the fault's bound.
    pub fn share(&self, bounds: &Bounds) -> f32 {
        self.acceleration.sum.abs() / bounds.speed
    }

    /// Whether acceleration and force both show motion.
    #[inline]
    pub fn moves(&self, bounds: &Bounds) -> bool {
        let (speed, momentum) = (self.acceleration.sum, self.force.sum);
        let needed = bounds.share * speed;
        speed.abs() > bounds.speed && if needed > 0.0 { momentum >= needed } else { momentum <= needed }
    }
}
