//! A virtual block of mass M rubs on the surface; spring K and damper B tie it to the handle (eq. 4.22-4.24).
//!
//! Per period, semi-implicitly: the coupling's force from handle and block as they are now (4.24), friction from the
//! block's velocity and that force, then a = (F_vc − F_f)/M (4.22), v, and p by the *new* v (4.23). The same F_vc acts
//! on the block and, reversed, on the handle over the coming period, so the coupling itself makes no energy. Clamping
//! it to what the actuator can give keeps that true when the handle is pulled away hard.
//!
//! A block that friction stops is at rest *exactly*: v = 0, no creep, no chatter, silence in the hand.

use super::block::{Block, limited};
use super::{Handle, Rendered};
use crate::Config;
use friction::{FrictionLaw, Law, Motion};

/// Rounding of the forces that add up to a stop, relative to them.
const ROUNDING: f32 = 1e-5;

impl Block {
    /// One period by eq. 4.22-4.24.
    pub(super) fn step_virtual_coupling(&mut self, config: &Config, handle: &Handle) -> Rendered {
        let limit = config.device.force_max;
        let stretched = config.stiffness * (handle.position - self.position)
            + config.damping * (handle.velocity - self.velocity);
        let coupling = limited(stretched, limit);
        let mut motion = Motion {
            dt: config.device.period,
            position: self.position,
            displacement: self.displacement,
            velocity: self.velocity,
            applied: coupling,
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
        let applied = coupling - extra;
        motion.applied = applied;
        let friction = config.law.step(&mut self.law, &motion);
        let rests = stops(config, applied, self.velocity, friction);
        self.velocity =
            if rests { 0.0 } else { self.velocity + (applied - friction) * config.period_per_mass };
        self.displacement = self.velocity * config.device.period;
        self.position += self.displacement;
        let stuck = match config.law {
            Law::Karnopp(_) | Law::Coulomb(_) => rests,
            // bristles hold without ever being quite at rest
            Law::Dahl(_) | Law::LuGre(_) => self.velocity.abs() < config.dv,
        };
        Rendered {
            force: -coupling,
            block_position: self.position,
            block_velocity: self.velocity,
            friction: friction + extra,
            stuck,
        }
    }
}

/// The friction force brings the block to rest within this period: it is the stopping force, to rounding; or, with
/// Karnopp inside his dead band, it balances what is applied, which is his definition of rest.
fn stops(config: &Config, applied: f32, velocity: f32, friction: f32) -> bool {
    let momentum = velocity * config.mass_per_period;
    let rounding = ROUNDING * (applied.abs() + momentum.abs());
    let brought_to_rest = (applied + momentum - friction).abs() <= rounding;
    let balanced = matches!(config.law, Law::Karnopp(_))
        && velocity.abs() < config.dv
        && (applied - friction).abs() <= rounding;
    brought_to_rest || balanced
}
