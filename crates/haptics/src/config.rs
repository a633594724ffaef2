//! Configuration of the loop: validated settings and device, with precomputed quotients.

use crate::compensation::gains::Gains;
use crate::excitation::Timing;
use crate::settings::MAX_EFFECTS;
use crate::{Biquad, Device, RendererKind, Settings};
use crate::{homing, silence};
use friction::effects::{Effect, EffectKind};
use friction::{Law, Scalar};

/// Share of m/T that the passivity controller may damp with: as the brake of a handle at rest, it halves the speed of a free
/// handle in one period.
const PASSIVITY_DAMPING: f32 = 0.5;

/// Time constant of the force difference after a swap, s: it vanishes in 20 ms, without a click and too fast to feel.
const BLEND_S: f32 = 6e-3;

/// A validated configuration. Only [`Settings::build`] makes one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    pub(crate) device: Device,
    pub(crate) renderer: RendererKind,
    pub(crate) law: Law<f32>,
    pub(crate) effects: [Option<Effect<f32>>; MAX_EFFECTS],
    /// Part of [`Self::effects`] that a contact evaluates in a swap.
    pub(crate) kinds: [Option<EffectKind>; MAX_EFFECTS],
    pub(crate) has_effects: bool,
    pub(crate) passivity: bool,
    pub(crate) feed_forward: Gains,
    /// Largest damping of the passivity controller, N·s/m.
    pub(crate) passivity_damping: f32,
    /// 1/2K, m/N.
    pub(crate) half_compliance: f32,
    pub(crate) dv: f32,
    pub(crate) mass: f32,
    pub(crate) stiffness: f32,
    pub(crate) damping: f32,
    /// T/M, s/kg.
    pub(crate) period_per_mass: f32,
    /// M/T, kg/s.
    pub(crate) mass_per_period: f32,
    /// KT/4 + B/2, N·s/m: share of the coupling's force from the old and from the new velocity of the block, each.
    pub(crate) coupling_share: f32,
    /// Counts per metre, 1/m.
    pub(crate) count_per_metre: f32,
    /// m/2T, N·s/m: the damping that halves the speed of a free handle in one period.
    pub(crate) edge_damping: f32,
    /// Speed of one count per tick, m/s.
    pub(crate) metre_per_second: f32,
    pub(crate) period_ticks: u32,
    /// Factor on the force difference of a swap per period.
    pub(crate) blend_decay: f32,
    pub(crate) low_pass: Biquad,
    pub(crate) timing: Timing,
    pub(crate) silence: silence::Bounds,
    pub(crate) homing: homing::Bounds,
    /// Largest force of a rendered contact while the middle of the stroke is unknown, N.
    pub(crate) unreferenced_force: f32,
    /// Distance from a stop at which a driven handle faults, and one that is held, m.
    pub(crate) driven: f32,
    pub(crate) held: f32,
    /// Whether its device is not that of the configuration before.
    pub(crate) new_device: bool,
}

impl Config {
    /// Builds without checks.
    pub(crate) fn new(settings: &Settings, device: &Device) -> Self {
        Self {
            device: *device,
            renderer: settings.renderer,
            law: settings.rendered_law(),
            effects: settings.effects,
            kinds: settings.effects.map(|effect| effect.map(|effect| effect.kind)),
            has_effects: settings.effects.iter().any(Option::is_some),
            passivity: settings.passivity,
            feed_forward: Gains::new(device),
            passivity_damping: PASSIVITY_DAMPING * device.mass / device.period,
            half_compliance: 0.5 / settings.k_vc,
            dv: settings.dv,
            mass: settings.mass,
            stiffness: settings.k_vc,
            damping: settings.b_vc,
            period_per_mass: device.period / settings.mass,
            mass_per_period: settings.mass / device.period,
            coupling_share: 0.25 * settings.k_vc * device.period + 0.5 * settings.b_vc,
            count_per_metre: 1.0 / device.metre_per_count,
            edge_damping: 0.5 * device.mass / device.period,
            metre_per_second: device.metre_per_count * device.tick_hz as f32,
            period_ticks: device.period_ticks(),
            blend_decay: Scalar::exp(device.period * (-1.0 / BLEND_S)),
            low_pass: Biquad::low_pass(device.command_cutoff_hz, device.period),
            timing: Timing::new(device.period),
            silence: silence::Bounds::new(device),
            homing: homing::Bounds::new(device),
            unreferenced_force: device.unreferenced_force(),
            driven: device.driven_margin(),
            held: device.held_margin(),
            new_device: false,
        }
    }

    /// The same, announced as that of another device: the loop that takes it up is idle and unreferenced from then on.
    #[must_use]
    pub fn on_new_device(self) -> Self {
        Self { new_device: true, ..self }
    }

    /// Timer ticks in a control period.
    #[must_use]
    pub fn period_ticks(&self) -> u32 {
        self.period_ticks
    }

    /// The device of this configuration.
    #[must_use]
    pub fn device(&self) -> &Device {
        &self.device
    }
}
