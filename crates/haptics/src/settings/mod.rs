//! What people set: one flat set of parameters in SI, validated against the device and built into a
//! [`Config`](crate::Config).

mod build;
mod effects;
mod parameters;
mod validate;

pub use parameters::{ALIASES, PARAMETERS, Parameter, SetError, Value};

use friction::effects::Effect;
use serde::{Deserialize, Serialize};

/// Effects a preset may add to its law.
pub const MAX_EFFECTS: usize = 4;

/// Which friction law the contact follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum LawKind {
    /// Modified Karnopp, eq. 3.1.
    #[default]
    Karnopp,
    /// Modified Dahl, eq. 3.2, 3.3.
    Dahl,
    /// Coulomb as a stopping force.
    Coulomb,
    /// LuGre.
    LuGre,
}

impl LawKind {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::Karnopp, Self::Dahl, Self::Coulomb, Self::LuGre];

    /// Name as typed.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Karnopp => "karnopp",
            Self::Dahl => "dahl",
            Self::Coulomb => "coulomb",
            Self::LuGre => "lugre",
        }
    }

    /// The law of this name.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|law| law.id() == id)
    }
}

/// What carries the friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum RendererKind {
    /// The handle itself rubs: table 4-1. `k_vc` is its K_p.
    Impedance,
    /// A virtual block of `mass` rubs, behind a spring `k_vc` and a damper `b_vc`: eq. 4.22-4.24.
    #[default]
    VirtualCoupling,
    /// The same block, its friction a stopping force solved within the step: sticks exactly, needs no `dv`.
    StoppingForce,
}

impl RendererKind {
    /// A virtual block rubs, not the handle itself.
    #[must_use]
    pub const fn has_block(self) -> bool {
        !matches!(self, Self::Impedance)
    }

    /// All of them.
    pub const ALL: &'static [Self] = &[Self::Impedance, Self::VirtualCoupling, Self::StoppingForce];

    /// Name as typed.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Impedance => "impedance",
            Self::VirtualCoupling => "virtual_coupling",
            Self::StoppingForce => "stopping_force",
        }
    }

    /// The renderer of this name.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|renderer| renderer.id() == id)
    }
}

/// A preset: everything that can be felt. All levels are magnitudes.
///
/// Saved presets are these fields in this order: what is changed here needs a new format number in
/// `link::PresetStore`, whose test `the_format_of_a_saved_preset_is_what_devices_hold` tells.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The law.
    pub law: LawKind,
    /// What carries it.
    pub renderer: RendererKind,
    /// Static friction against positive motion, N.
    pub f_static_p: f32,
    /// Static friction against negative motion, N.
    pub f_static_n: f32,
    /// Dynamic friction against positive motion, N; the limit force of Dahl.
    pub f_dynamic_p: f32,
    /// Dynamic friction against negative motion, N.
    pub f_dynamic_n: f32,
    /// Viscous damping against positive motion, N·s/m; may be negative while the whole stays dissipative.
    pub damping_p: f32,
    /// Viscous damping against negative motion, N·s/m.
    pub damping_n: f32,
    /// Δv: speed below which Karnopp's law takes the velocity for zero, m/s.
    pub dv: f32,
    /// Mass of the virtual block, kg.
    pub mass: f32,
    /// Stiffness of the virtual coupling, N/m; K_p of the impedance renderer.
    pub k_vc: f32,
    /// Damping of the virtual coupling, N·s/m; of the stuck spring with the impedance renderer.
    pub b_vc: f32,
    /// Bristle stiffness σ₀ of Dahl and LuGre, N/m.
    pub sigma: f32,
    /// Bristle damping σ₁ of LuGre, N·s/m.
    pub sigma_1: f32,
    /// Stribeck velocity of LuGre, m/s.
    pub stribeck_velocity: f32,
    /// Effects added to the law.
    pub effects: [Option<Effect<f32>>; MAX_EFFECTS],
}

impl Default for Settings {
    fn default() -> Self {
        Self::brass()
    }
}
