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
use friction::Law;

impl Block {
    /// One period by [thesis, eq. 4.22 to 4.24].
    // inline: a function of its own saves the registers of the step again
    #[inline(always)]
    pub(super) fn step_virtual_coupling(&mut self, config: &Config, handle: &Handle) -> Rendered {
        let limit = config.device.force_max;
        let stretched = config.stiffness * (handle.position - self.position)
            + config.damping * (handle.velocity - self.velocity);
        let coupling = limited(stretched, limit);
        let (friction, rests) = self.slide(config, coupling);
        self.displacement = self.velocity * config.device.period;
        self.position += self.displacement;
        let stuck = match config.law {
            Law::Karnopp(_) | Law::Coulomb(_) => rests,
            // a block held by bristles, or by none, is never exactly at rest
            _ => self.velocity.abs() < config.dv,
        };
        Rendered {
            force: -coupling,
            block_position: self.position,
            block_velocity: self.velocity,
            friction,
            stuck,
        }
    }
}
