//! Friction, the effects and Newton's law for a block that a force moves.

use super::block::Block;
use crate::Config;
use friction::{FrictionLaw, Law, Motion};

/// Relative rounding error of the forces that stop a block.
const ROUNDING: f32 = 1e-5;

impl Block {
    /// Velocity after a period under the force `push`, N, semi-implicitly. Friction with the effects, N, and whether friction
    /// brings the block to rest.
    // inline: a function of its own saves the registers of the step again
    #[inline(always)]
    pub(super) fn slide(&mut self, config: &Config, push: f32) -> (f32, bool) {
        let mut motion = Motion {
            dt: config.device.period,
            position: self.position,
            displacement: self.displacement,
            velocity: self.velocity,
            applied: push,
            mass: config.mass,
            normal: None,
        };
        let mut extra = 0.0;
        if config.has_effects {
            for (effect, state) in config.effects.iter().zip(&mut self.effects) {
                if let Some(effect) = effect {
                    extra += effect.step(state, &motion);
                }
            }
        }
        let applied = push - extra;
        motion.applied = applied;
        let friction = config.law.step(&mut self.law, &motion);
        let rests = stops(config, applied, self.velocity, friction);
        self.velocity =
            if rests { 0.0 } else { self.velocity + (applied - friction) * config.period_per_mass };
        (friction + extra, rests)
    }
}

/// Whether friction brings the block to rest within this period: it equals the stopping force up to rounding or, with Karnopp
/// inside the dead band, balances the applied force.
fn stops(config: &Config, applied: f32, velocity: f32, friction: f32) -> bool {
    let momentum = velocity * config.mass_per_period;
    let rounding = ROUNDING * (applied.abs() + momentum.abs());
    let brought_to_rest = (applied + momentum - friction).abs() <= rounding;
    let balanced = matches!(config.law, Law::Karnopp(_))
        && velocity.abs() < config.dv
        && (applied - friction).abs() <= rounding;
    brought_to_rest || balanced
}
