//! Gains of the feed-forward.

use crate::Device;
use friction::Scalar;

/// Time constant of the low-pass on the push, s.
const PUSH_S: f32 = 8e-3;

/// The compensation as the loop runs it: shares multiplied out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gains {
    pub(crate) is_on: bool,
    pub(crate) level_p: f32,
    pub(crate) level_n: f32,
    pub(crate) damping: f32,
    pub(crate) per_speed: f32,
    pub(crate) per_push: f32,
    /// Share of a new reading in the filtered push.
    pub(crate) learn: f32,
    pub(crate) has_effects: bool,
}

impl Gains {
    pub(crate) fn new(device: &Device) -> Self {
        let c = &device.compensation;
        Self {
            is_on: c.is_on(),
            level_p: c.share * c.friction_p,
            level_n: c.share * c.friction_n,
            damping: c.share * c.damping,
            per_speed: 1.0 / c.speed,
            per_push: 1.0 / c.push,
            learn: 1.0 - Scalar::exp(device.period * (-1.0 / PUSH_S)),
            has_effects: c.effects.iter().any(Option::is_some),
        }
    }
}
