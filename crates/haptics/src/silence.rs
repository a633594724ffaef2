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
/// Samples of silence before anything is said: a single wild one is not motion.
const SAMPLES: u8 = 3;

/// The bounds in what a step sums up: samples instead of seconds, so that it does not divide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    /// Share of the sums lost in a period.
    leak: f32,
    /// Share of an offset learned in a period.
    drift: f32,
    /// [`SPEED`] in m/s² · periods.
    speed: f32,
    /// Net force that must go with a unit of acceleration, kg.
    mass: f32,
}

impl Bounds {
    pub fn new(device: &Device) -> Self {
        Self {
            leak: device.period / MEMORY_S,
            drift: device.period / DRIFT_S,
            speed: SPEED / device.period,
            mass: SHARE * device.mass,
        }
    }
}

/// A signal without its offset, summed up since the last count.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sum {
    offset: f32,
    sum: f32,
}

impl Sum {
    #[inline]
    fn add(&mut self, value: f32, learn: f32, bounds: &Bounds) {
        let rest = value - self.offset;
        self.offset += learn * rest;
        self.sum += rest - bounds.leak * self.sum;
    }
}

/// What is remembered of the silence.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Silence {
    /// Count around which there is silence.
    around: u32,
    /// Samples of silence, saturating.
    samples: u8,
    /// Share of an offset learned in this period: 1/n at the n-th sample, so that it is the mean of all there were,
    /// until it comes down to that of [`DRIFT_S`]. 0 before the first sample.
    learn: f32,
    acceleration: Sum,
    force: Sum,
}

impl Silence {
    /// One sample; `command` is the force of the step before, N. True while the handle moves unseen.
    #[inline]
    pub fn sample(&mut self, bounds: &Bounds, device: &Device, inputs: &Inputs, command: f32) -> bool {
        let acceleration = device.accel.to_si(inputs.accel_code);
        let force = command - device.load.to_si(inputs.load_code);
        if self.learn == 0.0 {
            self.learn = 0.5;
            self.around = inputs.count;
            (self.acceleration.offset, self.force.offset) = (acceleration, force);
        } else if self.learn > bounds.drift {
            self.learn -= self.learn * self.learn;
        }
        self.acceleration.add(acceleration, self.learn, bounds);
        self.force.add(force, self.learn, bounds);
        // one count to and fro is what a dead channel of the two gives, and noise on an edge
        if inputs.count.wrapping_sub(self.around).wrapping_add(1) <= 2 {
            self.samples = self.samples.saturating_add(1);
            self.samples > SAMPLES && self.moves(bounds)
        } else {
            self.around = inputs.count;
            self.samples = 0;
            (self.acceleration.sum, self.force.sum) = (0.0, 0.0);
            false
        }
    }

    /// Speed that the accelerometer says and no count, as a share of what would be a fault.
    pub fn share(&self, bounds: &Bounds) -> f32 {
        self.acceleration.sum.abs() / bounds.speed
    }

    /// The handle moves, for all that acceleration and force say.
    #[inline]
    pub fn moves(&self, bounds: &Bounds) -> bool {
        let (speed, momentum) = (self.acceleration.sum, self.force.sum);
        if speed > 0.0 {
            speed > bounds.speed && momentum >= bounds.mass * speed
        } else {
            speed < -bounds.speed && momentum <= bounds.mass * speed
        }
    }
}
