//! A running excitation: a smooth reference, a PD controller, and a 100 Hz low-pass on the command [thesis, ch. 3.5.2].
//!
//! The amplitude ramps in from the present position of the handle and out to the middle of the stroke, both with continuous
//! acceleration.

use crate::filter::BiquadState;
use crate::generator::Generator;
use crate::{Config, Excitation};

/// Progress of an excitation, and the state of its controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    generator: Generator,
    amplitude: f32,
    start: f32,
    reference: f32,
    elapsed: u32,
    /// Step at which the ramp-out begins.
    out_at: u32,
    filter: BiquadState,
}

impl Drive {
    /// Starts at the present position of the handle. The excitation must be valid.
    #[inline(always)] // constructed in place, like a contact
    pub(crate) fn start(config: &Config, excitation: &Excitation, position: f32) -> Self {
        let steps = excitation.seconds * config.timing.rate;
        Self {
            generator: Generator::new(excitation, config.device.period),
            amplitude: excitation.amplitude_m,
            start: position,
            reference: position,
            elapsed: 0,
            // `as` saturates
            out_at: if excitation.seconds > 0.0 { steps as u32 } else { u32::MAX },
            filter: BiquadState::default(),
        }
    }

    /// Begins the ramp-out, unless it has begun.
    pub(crate) fn stop(&mut self) {
        self.out_at = self.out_at.min(self.elapsed);
    }

    /// Periods since the start.
    #[must_use]
    pub fn elapsed(&self) -> u32 {
        self.elapsed
    }

    /// Reference position, m.
    #[must_use]
    pub fn reference(&self) -> f32 {
        self.reference
    }

    /// One period: the command before the clamp, N, or `None` after the end.
    pub(crate) fn step(&mut self, config: &Config, position: f32, velocity: f32) -> Option<f32> {
        let timing = &config.timing;
        let since_out = self.elapsed.saturating_sub(self.out_at) as f32;
        let out = since_out * timing.per_ramp_out;
        let fade = (since_out - timing.ramp_out) * timing.per_fade;
        if fade >= 1.0 {
            return None;
        }
        let ramp_in = ease(self.elapsed as f32 * timing.per_ramp_in);
        let envelope = ramp_in * (1.0 - ease(out));
        let unit = self.generator.next();
        // from the start to the middle of the stroke; a stop during the ramp-in also removes the rest of it
        let home = self.start * (1.0 - ramp_in) * (1.0 - ease(out));
        let reference = home + self.amplitude * envelope * unit;
        let reference_velocity = (reference - self.reference) * timing.rate;
        self.reference = reference;
        self.elapsed = self.elapsed.saturating_add(1);
        let device = &config.device;
        let command = device.tracking_stiffness * (reference - position)
            + device.tracking_damping * (reference_velocity - velocity);
        let command = config.low_pass.step(&mut self.filter, command);
        Some(if fade > 0.0 { command * (1.0 - ease(fade)) } else { command })
    }
}

/// Smooth step: 0 below 0, 1 above 1, between them 10u³ − 15u⁴ + 6u⁵ with continuous second derivative.
fn ease(u: f32) -> f32 {
    if u <= 0.0 {
        0.0
    } else if u >= 1.0 {
        1.0
    } else {
        u * u * u * (10.0 - u * (15.0 - 6.0 * u))
    }
}
