//! State of a virtual block behind the coupling.

use super::Handle;
use super::dither::Dither;
use crate::settings::MAX_EFFECTS;
use crate::{Config, RendererKind};
use core::mem::{Discriminant, discriminant};
use friction::effects::{EffectKind, EffectState};
use friction::{Law, LawState};

/// State of the block and of its contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    pub(super) position: f32,
    pub(super) velocity: f32,
    pub(super) displacement: f32,
    pub(super) dither: Dither,
    /// Force of the hand that the block feels, N.
    #[cfg(feature = "admittance")]
    pub(super) push: f32,
    /// Samples for which it has been at rest.
    #[cfg(feature = "admittance")]
    pub(super) rested: u8,
    pub(super) law: LawState<f32>,
    renderer: RendererKind,
    law_kind: Discriminant<Law<f32>>,
    pub(super) effects: [EffectState<f32>; MAX_EFFECTS],
    kinds: [Option<EffectKind>; MAX_EFFECTS],
}

impl Block {
    /// A block at the handle, with its velocity: no force.
    #[inline(always)] // constructed in place: a copy costs a tenth of a control step
    pub(crate) fn new(config: &Config, handle: &Handle) -> Self {
        Self {
            position: handle.position,
            velocity: handle.velocity,
            displacement: 0.0,
            dither: Dither::default(),
            #[cfg(feature = "admittance")]
            push: handle.push,
            #[cfg(feature = "admittance")]
            rested: 0,
            law: LawState::default(),
            renderer: config.renderer,
            law_kind: discriminant(&config.law),
            effects: [EffectState::default(); MAX_EFFECTS],
            kinds: config.kinds,
        }
    }

    pub(crate) fn fits(&self, config: &Config, renderer: RendererKind) -> bool {
        self.renderer == renderer && self.law_kind == discriminant(&config.law) && self.kinds == config.kinds
    }
}

/// `force` within ±`limit`. NaN stays NaN and becomes a fault.
pub(super) fn limited(force: f32, limit: f32) -> f32 {
    if force > limit {
        limit
    } else if force < -limit {
        -limit
    } else {
        force
    }
}
