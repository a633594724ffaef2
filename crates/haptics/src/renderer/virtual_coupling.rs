//! Virtual-coupling renderer: a virtual block of mass M slides on the surface, tied to the handle by spring K and damper B
//! [thesis, eq. 4.22 to 4.24].
//!
//! Each period, semi-implicitly: the coupling force from handle and block, friction from the velocity of the block and that
//! force, then a = (F_vc − F_f)/M, v, and p with the *new* v. The same F_vc acts on the block and, reversed, on the handle, so
//! the coupling adds no energy; clamping it to the limit of the actuator keeps that true under a hard pull.
//!
//! A block that friction stops is *exactly* at rest: v = 0, no creep, no chatter.

use super::block::{Block, limited};
use super::{Handle, Rendered};
use crate::Config;
use friction::{FrictionLaw, Law, Motion};

/// Relative rounding error of the forces that stop a block.
const ROUNDING: f32 = 1e-5;

impl Block {
    /// One period by [thesis, eq. 4.22 to 4.24].
    // inline: a function of its own saves the registers of the step again
    #[inline(always)]
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
            // a block held by bristles is never exactly at rest
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

/// Whether friction brings the block to rest within this period: it equals the stopping force up to rounding or, with Karnopp
/// inside the dead band, balances the applied force.
pub(super) fn stops(config: &Config, applied: f32, velocity: f32, friction: f32) -> bool {
    let momentum = velocity * config.mass_per_period;
    let rounding = ROUNDING * (applied.abs() + momentum.abs());
    let brought_to_rest = (applied + momentum - friction).abs() <= rounding;
    let balanced = matches!(config.law, Law::Karnopp(_))
        && velocity.abs() < config.dv
        && (applied - friction).abs() <= rounding;
    brought_to_rest || balanced
}
