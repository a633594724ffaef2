//! The checks that withdraw force. Each is one comparison against a constant of the [`Device`].

use crate::silence::{Bounds, Silence};
use crate::{Device, FaultKind, Inputs};

/// Samples in a row at a rail before it is a fault: an impact saturates the accelerometer for a sample or two.
const RAIL_SAMPLES: u8 = 3;

/// Highest code: 12-bit conversions summed 16 times.
const TOP_CODE: u16 = 65_520;

/// What one step knows of the motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion {
    pub position: f32,
    pub velocity: f32,
    /// Moved in the last period, m.
    pub displacement: f32,
    /// Ticks between the last two samples; `None` at the first.
    pub elapsed: Option<u32>,
    /// The handle is driven, not held: the end of the stroke is to be avoided, not only detected.
    pub driven: bool,
    /// Force of the step before, N.
    pub command: f32,
}

/// What the checks remember.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Guard {
    previous_velocity: f32,
    rails: u8,
    /// Steps until the host's promise is broken; `None`: no promise.
    host: Option<u32>,
    silence: Silence,
}

impl Guard {
    /// The host promises to speak again within so many steps; 0 takes the promise back.
    pub(crate) fn watch(&mut self, steps: u32) {
        self.host = if steps == 0 { None } else { Some(steps) };
    }

    /// The handle moves although the encoder does not say so.
    pub(crate) fn moves_unseen(&self, silence: &Bounds) -> bool {
        self.silence.moves(silence)
    }

    /// What was summed up belongs to another period.
    pub(crate) fn period_changes(&mut self) {
        self.silence.afresh();
    }

    /// See [`Silence::share`].
    pub(crate) fn unseen(&self, silence: &Bounds) -> f32 {
        self.silence.share(silence)
    }

    /// Runs every check; call once a step in every mode, so that the memory is right when force comes on.
    pub(crate) fn check(
        &mut self,
        device: &Device,
        period_ticks: u32,
        silence: &Bounds,
        inputs: &Inputs,
        m: &Motion,
    ) -> Option<FaultKind> {
        let expected = self.previous_velocity * device.period;
        self.previous_velocity = m.velocity;
        self.rails = if at_rail(device, inputs) { self.rails.saturating_add(1) } else { 0 };
        if let Some(left) = &mut self.host {
            *left = left.saturating_sub(1);
        }
        let silent = self.silence.sample(silence, inputs, m.command);
        let half_stroke = 0.5 * device.stroke;
        // driven: stop 0.5 mm before the stops. Held by a hand: stops are reached in normal use, 1 mm beyond is not.
        let limit = if m.driven { half_stroke - 0.5e-3 } else { half_stroke + 1e-3 };

        if m.elapsed.is_some_and(|ticks| ticks > period_ticks + period_ticks / 2 || ticks < period_ticks / 2)
        {
            Some(FaultKind::MissedDeadline)
        } else if (m.displacement - expected).abs() > silence.jump {
            Some(FaultKind::EncoderJump)
        } else if m.velocity.abs() > device.overspeed {
            Some(FaultKind::Overspeed)
        } else if m.position.abs() > limit {
            Some(FaultKind::EndOfStroke)
        } else if self.rails >= RAIL_SAMPLES {
            Some(FaultKind::SensorRail)
        } else if silent {
            Some(FaultKind::EncoderSilent)
        } else if self.host == Some(0) {
            Some(FaultKind::HostSilent)
        } else {
            None
        }
    }
}

/// Either converter is at an end of its scale.
pub(crate) fn at_rail(device: &Device, inputs: &Inputs) -> bool {
    let low = device.rail_codes;
    // one comparison for both ends: below `low` the difference wraps
    let span = TOP_CODE.saturating_sub(low).saturating_sub(low);
    inputs.load_code.wrapping_sub(low) > span || inputs.accel_code.wrapping_sub(low) > span
}

/// The command that may leave the step: within ±`force_max`, or `None` when it is not a number.
pub(crate) fn clamp(force: f32, force_max: f32) -> Option<f32> {
    if !force.is_finite() {
        None
    } else if force > force_max {
        Some(force_max)
    } else if force < -force_max {
        Some(-force_max)
    } else {
        Some(force)
    }
}
