//! Admittance renderer: the force of the hand, by the load cell, moves a virtual mass with friction; the handle follows it
//! through a position loop [keemink-2018].
//!
//! ```text
//! M (w⁺ − w)/T = F_h − F,      p⁺ = p + T w⁺       F_h hand's force, F friction as a stopping force
//! u = K (p⁺ − x) + B (w⁺ − v)                      force of the actuator
//! ```
//!
//! The virtual coupling drives the block with the force of its own spring, so the hand feels the block *and* the device:
//! mass M + m, damping b. Here the block hears the hand alone. Mass and damping of the device are inside the position loop,
//! and the hand feels M, with what is between its fingers and the load cell.
//!
//! Friction is solved with the new velocity (as Coulomb's law, also for Karnopp's levels: no dead band), so a block pushed by
//! less than its static friction is exactly at rest. Then the noise of the load cell does not reach the handle.
//!
//! A hand stronger than the actuator drags the block along: the spring is never stretched beyond the largest force.

use super::block::{Block, limited};
use super::{Handle, Rendered};
use crate::Config;

impl Block {
    /// One period of the equations above.
    pub(super) fn step_admittance(&mut self, config: &Config, handle: &Handle) -> Rendered {
        let limit = config.device.force_max;
        let (friction, stuck) = self.slide(config, handle.push);
        let before = self.position;
        self.position += self.velocity * config.device.period;
        let lead = self.position - handle.position;
        let most = limited(lead, limit / config.stiffness);
        if lead != most {
            self.position = handle.position + most;
        }
        self.displacement = self.position - before;
        let follow = config.stiffness * (self.position - handle.position)
            + config.damping * (self.velocity - handle.velocity);
        Rendered {
            force: limited(follow, limit),
            block_position: self.position,
            block_velocity: self.velocity,
            friction,
            stuck,
        }
    }
}
