//! The checks that withdraw force. Each is one comparison against a constant of the [`Device`].

use crate::silence::{Bounds, Silence};
use crate::{Device, FaultKind, Inputs};

/// Consecutive samples at a rail that are a fault. An impact saturates the accelerometer for a sample or two.
const RAIL_SAMPLES: u8 = 3;

/// Motion in one step, as the checks see it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion {
    pub position: f32,
    pub velocity: f32,
    /// Displacement in the last period, m.
    pub displacement: f32,
    /// Time between the last two samples, ticks. `None` at the first.
    pub elapsed: Option<u32>,
    /// Largest distance from position 0, m.
    pub reach: f32,
    /// Force of the previous step, N.
    pub command: f32,
}

/// State of the checks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Guard {
    previous_velocity: f32,
    rails: u8,
    /// Steps until the promise of the host is broken. `None` without a promise.
    host: Option<u32>,
    silence: Silence,
}

impl Guard {
    /// Sets the promise of the host to report within `steps`. 0 withdraws it.
    pub(crate) fn watch(&mut self, steps: u32) {
        self.host = if steps == 0 { None } else { Some(steps) };
    }

    /// Whether the handle moves although the encoder shows rest.
    pub(crate) fn moves_unseen(&self, silence: &Bounds) -> bool {
        self.silence.moves(silence)
    }

    /// Discards sums of another control period.
    pub(crate) fn period_changes(&mut self) {
        self.silence.afresh();
    }

    /// Learns the offsets of the sensors from the start: the supply is their reference, and it broke down.
    pub(crate) fn forget_offsets(&mut self) {
        self.silence = Silence::default();
    }

    /// See [`Silence::share`].
    pub(crate) fn unseen(&self, silence: &Bounds) -> f32 {
        self.silence.share(silence)
    }

    /// Runs every check. Call it once per step in every mode, so that its state is valid when force comes on.
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

        if m.elapsed.is_some_and(|ticks| ticks > period_ticks + period_ticks / 2 || ticks < period_ticks / 2)
        {
            Some(FaultKind::MissedDeadline)
        } else if (m.displacement - expected).abs() > silence.jump {
            Some(FaultKind::EncoderJump)
        } else if m.velocity.abs() > device.overspeed {
            Some(FaultKind::Overspeed)
        } else if m.position.abs() > m.reach {
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

/// Whether either converter is at an end of its scale.
pub(crate) fn at_rail(device: &Device, inputs: &Inputs) -> bool {
    let low = device.rail_codes;
    // one comparison for both ends: below `low` the difference wraps
    let span = Inputs::TOP_CODE.saturating_sub(low).saturating_sub(low);
    inputs.load_code.wrapping_sub(low) > span || inputs.accel_code.wrapping_sub(low) > span
}

/// Command within ±`force_max`. `None` for NaN.
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
