//! The virtual contact on the handle. Four renderers: friction on the handle itself (impedance, [thesis, table 4-1]); on a
//! virtual block behind a spring and damper, stepped by [thesis, eq. 4.22 to 4.24] (virtual coupling) or with friction and
//! coupling solved together (stopping force); on a block that the load cell moves and the handle follows (admittance; with
//! the feature `admittance`: its bound takes a board longer than its watchdog waits).

#[cfg(feature = "admittance")]
mod admittance;
mod block;
mod dither;
mod impedance;
mod levels;
mod slide;
mod stopping_force;
mod virtual_coupling;

pub use block::Block;
pub use impedance::Impedance;

use crate::{Config, RendererKind};
use friction::FrictionLaw;
use levels::Levels;

/// Measured motion of the handle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Handle {
    /// m.
    pub position: f32,
    /// m/s.
    pub velocity: f32,
    /// Displacement since the last step, m.
    pub displacement: f32,
    /// Force of the hand on the handle by the load cell, N.
    #[cfg(feature = "admittance")]
    pub push: f32,
}

impl Handle {
    /// Predicted motion after `period` s at constant velocity.
    pub(crate) fn after(&self, period: f32) -> Self {
        Self { position: self.position + self.velocity * period, ..*self }
    }
}

/// Result of one step of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rendered {
    /// Force on the handle before the clamp, N.
    pub force: f32,
    /// Position of the sliding body, m.
    pub block_position: f32,
    /// Velocity of the sliding body, m/s.
    pub block_velocity: f32,
    /// Friction force, N, positive against positive motion.
    pub friction: f32,
    /// Whether the contact sticks.
    pub stuck: bool,
}

/// A contact with its state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contact {
    /// Friction on the handle itself.
    Impedance(Impedance),
    /// Friction on a virtual block: virtual coupling, stopping force or admittance.
    Block(Block),
}

impl Contact {
    /// A fresh contact at the handle, without force.
    #[must_use]
    #[inline(always)]
    pub fn new(config: &Config, handle: &Handle) -> Self {
        match config.renderer {
            RendererKind::Impedance => Self::Impedance(Impedance::new(config, handle)),
            // constructed in place for all of them
            _ => Self::Block(Block::new(config, handle)),
        }
    }

    /// Whether this state fits the configuration: same renderer, law and effects.
    pub(crate) fn fits(&self, config: &Config) -> bool {
        match (self, config.renderer) {
            (Self::Impedance(contact), RendererKind::Impedance) => contact.fits(config),
            (Self::Block(block), renderer) => block.fits(config, renderer),
            _ => false,
        }
    }

    /// Energy in spring, block and bristles that the handle may get back, J.
    pub(crate) fn stored(&self, config: &Config, handle: &Handle) -> f32 {
        let (spring, velocity, law) = match self {
            Self::Impedance(contact) => (contact.spring(config, handle), 0.0, &contact.law),
            Self::Block(block) => {
                (config.stiffness * (handle.position - block.position), block.velocity, &block.law)
            }
        };
        spring * spring * config.half_compliance
            + 0.5 * config.mass * velocity * velocity
            + config.law.stored(law)
    }

    /// Takes `energy`, J, from the motion of a block, half of its speed at most.
    #[cfg(feature = "admittance")]
    pub(crate) fn brake(&mut self, config: &Config, energy: f32) {
        if let Self::Block(block) = self {
            let momentum = config.mass * block.velocity;
            let lost = energy / (momentum * block.velocity);
            // of a block at rest there is nothing to take
            if lost > 0.0 {
                block.velocity -= if lost < 0.5 { lost } else { 0.5 } * block.velocity;
            }
        }
    }

    /// One period: the force for the motion of the handle.
    pub fn step(&mut self, config: &Config, handle: &Handle) -> Rendered {
        let block = match self {
            Self::Impedance(contact) => return contact.step(config, handle),
            Self::Block(block) => block,
        };
        if config.renderer == RendererKind::StoppingForce
            && let Some(levels) = Levels::of(&config.law)
        {
            return block.step_stopping_force(config, handle, levels);
        }
        #[cfg(feature = "admittance")]
        if config.renderer == RendererKind::Admittance {
            return block.step_admittance(config, handle);
        }
        // also under the stopping force, for a law that has no set-valued part
        block.step_virtual_coupling(config, handle)
    }
}
