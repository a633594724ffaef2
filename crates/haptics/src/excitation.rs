//! Excitation for identification [thesis, ch. 3.5.2], as it is requested: shape, amplitude, frequency, length.

use crate::{Accepted, Device, Reason, Refused, Wave};
use friction::Dimension;

/// Length of the ramp at the start, s.
pub const RAMP_IN_S: f32 = 1.0;
/// Length of the ramp at the end, s.
pub const RAMP_OUT_S: f32 = 0.5;
/// Fade-out of the command after the ramp, s.
const FADE_S: f32 = 0.1;
/// Longest excitation, s.
const LONGEST_S: f32 = 3_600.0;
/// Distance that an excitation keeps from the stops, m, on the default device.
const STOPS: f32 = 1e-3;
/// Lowest frequency, Hz.
const SLOWEST_HZ: f32 = 0.005;

/// A requested excitation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excitation {
    /// Shape of the reference.
    pub wave: Wave,
    /// Amplitude, half of the peak-to-peak value, m.
    pub amplitude_m: f32,
    /// Repetition rate, Hz. For a chirp, the highest frequency.
    pub frequency_hz: f32,
    /// Time from the start of the ramp-in to the start of the ramp-out, s. 0 runs until stopped.
    pub seconds: f32,
}

impl Default for Excitation {
    /// A sine of 2 Hz and 10 mm for 12 s [thesis, ch. 3.5.2].
    fn default() -> Self {
        Self { wave: Wave::Sine, amplitude_m: 0.01, frequency_hz: 2.0, seconds: 12.0 }
    }
}

impl Excitation {
    /// Checks the excitation against stroke, speed and force of the device.
    ///
    /// # Errors
    /// The parameter that is out of range, with the value that would be accepted.
    pub fn validate(&self, device: &Device) -> Result<(), Refused> {
        let refuse =
            |parameter, value, accepted, why| Err(Refused { effect: None, parameter, value, accepted, why });
        let half = 0.5 * device.stroke - device.length(STOPS);
        if !(self.amplitude_m > 0.0 && self.amplitude_m <= half) {
            let accepted = Accepted::Between(device.metre_per_count, half);
            return refuse(
                "amplitude",
                self.amplitude_m,
                accepted,
                Reason::of(Dimension::LENGTH, "3 % inside the stroke"),
            );
        }
        if !(self.frequency_hz >= SLOWEST_HZ && self.is_slow_enough(device)) {
            let fastest = self.fastest(device);
            let why = Reason::of(
                Dimension::FREQUENCY,
                "the actuator's force and the device's speed at this amplitude end there",
            );
            return refuse("frequency", self.frequency_hz, Accepted::Between(SLOWEST_HZ, fastest), why);
        }
        if !(self.seconds >= 0.0 && self.seconds <= LONGEST_S) {
            return refuse(
                "seconds",
                self.seconds,
                Accepted::Between(0.0, LONGEST_S),
                Reason::of(Dimension::TIME, "0 runs until stopped"),
            );
        }
        Ok(())
    }

    /// Whether the frequency is at most [`Self::fastest`], up to rounding. Without a square root, as part of a control step.
    fn is_slow_enough(&self, device: &Device) -> bool {
        let turn_rate = core::f32::consts::TAU * self.frequency_hz;
        let speed = turn_rate * self.wave.speed_factor() * self.amplitude_m;
        let force = turn_rate * turn_rate * device.mass * self.wave.acceleration_factor() * self.amplitude_m;
        force <= device.force_max
            && speed <= 0.5 * device.overspeed
            && self.frequency_hz * device.period <= 0.1
    }

    /// Highest frequency that force and speed allow at this amplitude, Hz, rounded down to a number that is easy to type.
    pub(crate) fn fastest(&self, device: &Device) -> f32 {
        use friction::Scalar;
        let turn = core::f32::consts::TAU;
        let by_force = device.force_max / (device.mass * self.wave.acceleration_factor() * self.amplitude_m);
        let by_force = Scalar::sqrt(by_force) / turn;
        let by_speed = 0.5 * device.overspeed / (self.wave.speed_factor() * self.amplitude_m * turn);
        let limit = Scalar::min(Scalar::min(by_force, by_speed), 0.1 / device.period);
        libm::floorf(limit * 100.0) / 100.0
    }
}

/// Ramp lengths in the units of the step, which then does not divide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Timing {
    pub rate: f32,
    pub per_ramp_in: f32,
    pub per_ramp_out: f32,
    pub ramp_out: f32,
    pub per_fade: f32,
}

impl Timing {
    pub(crate) fn new(period: f32) -> Self {
        Self {
            rate: 1.0 / period,
            per_ramp_in: period / RAMP_IN_S,
            per_ramp_out: period / RAMP_OUT_S,
            ramp_out: RAMP_OUT_S / period,
            per_fade: period / FADE_S,
        }
    }
}
