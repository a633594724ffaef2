//! The feed-forward in the control step.

use crate::Config;
use crate::renderer::Handle;
use friction::Motion;
use friction::effects::EffectState;

/// State of the feed-forward.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct FeedForward {
    /// Push of the hand behind the low-pass, N.
    push: f32,
    /// Force of the last step, N.
    pub(crate) force: f32,
}

/// `x` within −1 and 1. NaN stays.
#[allow(clippy::manual_clamp)] // `clamp` has a panic, which the control interrupt must not reach
fn one(x: f32) -> f32 {
    if x > 1.0 {
        1.0
    } else if x < -1.0 {
        -1.0
    } else {
        x
    }
}

impl FeedForward {
    /// The force to add to `force`, N. `load_code` is the reading of the load cell.
    // a function of its own: without it the step has the cycles it had before
    #[inline(never)]
    pub(crate) fn step(&mut self, config: &Config, handle: &Handle, load_code: u16, force: f32) -> f32 {
        let gains = &config.feed_forward;
        // the cell shows the reaction
        self.push += gains.learn * (-config.device.load.to_si(load_code) - self.push);
        let v = handle.velocity;
        let by_speed = one(v * gains.per_speed);
        let direction = by_speed + (1.0 - by_speed.abs()) * one(self.push * gains.per_push);
        let level = if direction > 0.0 { gains.level_p } else { gains.level_n };
        let mut sum = level * direction + gains.damping * v;
        if gains.has_effects {
            let compensation = &config.device.compensation;
            let motion = Motion { position: handle.position, applied: force, ..Motion::default() };
            for effect in compensation.effects.iter().flatten() {
                sum += compensation.share * effect.step(&mut EffectState::default(), &motion);
            }
        }
        self.force = sum;
        sum
    }
}
