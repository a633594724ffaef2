//! The virtual contact on the handle, in three ways: the handle itself rubs (impedance, table 4-1), or a virtual block
//! behind a spring and damper does, stepped as in the thesis (virtual coupling, eq. 4.22-4.24) or with friction and
//! coupling solved together (stopping force).

mod block;
mod dither;
mod impedance;
mod stopping_force;
mod virtual_coupling;

pub use block::Block;
pub use impedance::Impedance;

use crate::{Config, RendererKind};

/// Motion of the handle as measured.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Handle {
    /// m.
    pub position: f32,
    /// m/s.
    pub velocity: f32,
    /// Moved since the last step, m.
    pub displacement: f32,
}

impl Handle {
    /// Where it will be in `period` s if it goes on as it does.
    pub(crate) fn after(&self, period: f32) -> Self {
        Self { position: self.position + self.velocity * period, ..*self }
    }
}

/// What a contact did in one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rendered {
    /// Force on the handle before the clamp, N.
    pub force: f32,
    /// Position of what rubs, m.
    pub block_position: f32,
    /// Velocity of what rubs, m/s.
    pub block_velocity: f32,
    /// Friction force, N, positive against positive motion.
    pub friction: f32,
    /// Nothing slides.
    pub stuck: bool,
}

/// A contact and its memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contact {
    /// Friction on the handle itself.
    Impedance(Impedance),
    /// Friction on a virtual block, as in the thesis or as a stopping force.
    Block(Block),
}

impl Contact {
    /// A fresh contact where the handle is, without force.
    #[must_use]
    #[inline(always)]
    pub fn new(config: &Config, handle: &Handle) -> Self {
        match config.renderer {
            RendererKind::Impedance => Self::Impedance(Impedance::new(config, handle)),
            // one place for both: it is made where it stays
            RendererKind::VirtualCoupling | RendererKind::StoppingForce => {
                Self::Block(Block::new(config, handle))
            }
        }
    }

    /// This memory belongs to that configuration: same renderer, same law, same effects.
    pub(crate) fn fits(&self, config: &Config) -> bool {
        match (self, config.renderer) {
            (Self::Impedance(contact), RendererKind::Impedance) => contact.fits(config),
            (Self::Block(block), renderer) => block.fits(config, renderer),
            _ => false,
        }
    }

    /// One period: the force that answers the handle's motion.
    pub fn step(&mut self, config: &Config, handle: &Handle) -> Rendered {
        match self {
            Self::Impedance(contact) => contact.step(config, handle),
            Self::Block(block) if config.renderer == RendererKind::StoppingForce => {
                block.step_stopping_force(config, handle)
            }
            Self::Block(block) => block.step_virtual_coupling(config, handle),
        }
    }
}
