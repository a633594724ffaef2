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
//! less than its static friction is exactly at rest. Then the noise of the load cell does not reach the handle; a handle that
//! oscillates between two counts is settled and braked as under the stopping force ([`super::dither`]).
//!
//! A hand stronger than the actuator drags the block along: the spring is never stretched beyond the largest force.

use super::block::{Block, limited};
use super::{Handle, Rendered};
use crate::Config;

/// Samples after which a block has come to rest.
const RESTED: u8 = 20;
/// Share of a new reading in the force that such a block feels: an average over some 20 samples.
const SMOOTHED: f32 = 0.1;

impl Block {
    /// One period of the equations above.
    pub(super) fn step_admittance(&mut self, config: &Config, handle: &Handle) -> Rendered {
        let limit = config.device.force_max;
        // a block that has come to rest is not broken away by the noise of one sample
        self.rested = if self.velocity == 0.0 { self.rested.saturating_add(1) } else { 0 };
        let share = if self.rested > RESTED { SMOOTHED } else { 1.0 };
        self.push += share * (handle.push - self.push);
        let (friction, stuck) = self.slide(config, self.push);
        let before = self.position;
        self.position += self.velocity * config.device.period;
        let lead = self.position - handle.position;
        let most = limited(lead, limit / config.stiffness);
        if lead != most {
            self.position = handle.position + most;
        }
        self.displacement = self.position - before;
        let x = self.dither.settle(handle, config.device.metre_per_count, config.count_per_metre);
        let brake = self.dither.brake(handle, config.edge_damping);
        let follow = config.stiffness * (self.position - x)
            + config.damping * (self.velocity - handle.velocity)
            - brake;
        Rendered {
            force: limited(follow, limit),
            block_position: self.position,
            block_velocity: self.velocity,
            friction,
            stuck,
        }
    }
}
