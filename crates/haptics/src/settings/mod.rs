//! Settings: one flat set of parameters in SI, validated against the device and built into a [`Config`](crate::Config).

mod build;
mod effects;
mod parameters;
mod validate;

pub use effects::{EFFECTS_CYCLES, PASSIVITY_CYCLES, effect_cycles, law_cycles};
pub(crate) use effects::{named, parameter_of};
pub use parameters::{ALIASES, PARAMETERS, Parameter, SetError, SetWhy, Value};

use friction::Adhesion;
pub use friction::LawKind;
use friction::effects::Effect;
use serde::{Deserialize, Serialize};

/// Largest number of effects of a preset.
pub const MAX_EFFECTS: usize = 4;

/// Renderer of the contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum RendererKind {
    /// Friction on the handle itself [thesis, table 4-1]. `k_vc` is its K_p.
    Impedance,
    /// Friction on a virtual block of `mass` behind a spring `k_vc` and a damper `b_vc` [thesis, eq. 4.22 to 4.24].
    #[default]
    VirtualCoupling,
    /// The same block with friction as a stopping force, solved within the step: sticks exactly, needs no `dv`.
    StoppingForce,
    /// The load cell moves the block, the handle follows it.
    #[cfg(feature = "admittance")]
    Admittance,
}

impl RendererKind {
    /// Whether friction acts on a virtual block.
    #[must_use]
    pub const fn has_block(self) -> bool {
        !matches!(self, Self::Impedance)
    }

    /// Those that a board has.
    pub const ON_BOARD: &'static [Self] = &[Self::Impedance, Self::VirtualCoupling, Self::StoppingForce];

    /// All that this build has.
    #[cfg(not(feature = "admittance"))]
    pub const ALL: &'static [Self] = Self::ON_BOARD;

    /// All that this build has.
    #[cfg(feature = "admittance")]
    pub const ALL: &'static [Self] =
        &[Self::Impedance, Self::VirtualCoupling, Self::StoppingForce, Self::Admittance];

    /// Name as typed.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Impedance => "impedance",
            Self::VirtualCoupling => "virtual_coupling",
            Self::StoppingForce => "stopping_force",
            #[cfg(feature = "admittance")]
            Self::Admittance => "admittance",
        }
    }

    /// The renderer with this name.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|renderer| renderer.id() == id)
    }
}

/// A preset: all parameters of the rendered contact. Levels are magnitudes.
///
/// A saved preset is these fields in this order. A change needs a new format number in `link::PresetStore`; its test
/// `the_format_of_a_saved_preset_is_what_devices_hold` fails otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The law.
    pub law: LawKind,
    /// The renderer.
    pub renderer: RendererKind,
    /// Static friction against positive motion, N.
    pub f_static_p: f32,
    /// Static friction against negative motion, N.
    pub f_static_n: f32,
    /// Dynamic friction against positive motion, N. The limit force of Dahl.
    pub f_dynamic_p: f32,
    /// Dynamic friction against negative motion, N.
    pub f_dynamic_n: f32,
    /// Viscous damping against positive motion, N·s/m. May be negative as long as total friction is dissipative.
    pub damping_p: f32,
    /// Viscous damping against negative motion, N·s/m.
    pub damping_n: f32,
    /// Δv, half-width of the stuck velocity band of Karnopp's law, m/s. Of the classic law, the speed at which static friction
    /// is reached.
    pub dv: f32,
    /// Mass of the virtual block, kg.
    pub mass: f32,
    /// Stiffness of the virtual coupling, N/m. K_p of the impedance renderer.
    pub k_vc: f32,
    /// Damping of the virtual coupling, N·s/m. With the impedance renderer, of the stuck spring.
    pub b_vc: f32,
    /// Stiffness σ₀ of the contact before it slides, of a law with bristles, N/m.
    pub sigma: f32,
    /// Bristle damping σ₁ of LuGre and of the elasto-plastic law, N·s/m.
    pub sigma_1: f32,
    /// Speed at which static friction has fallen to dynamic friction, m/s.
    pub stribeck_velocity: f32,
    /// Effects added to the law.
    pub effects: [Option<Effect<f32>>; MAX_EFFECTS],
    /// Whether energy that nothing stored is taken back before it leaves (passivity observer and controller).
    #[serde(default)]
    pub passivity: bool,
    /// Elastic range of the elasto-plastic law as a share of the dynamic friction.
    pub elastic: f32,
    /// Rate at which a slipping element of Maxwell slip follows the level, N/s.
    pub attraction: f32,
    /// Time constant of the frictional memory of Armstrong's law, s.
    pub memory: f32,
    /// Time at rest after which static friction of Armstrong's law has risen by half, s.
    pub dwell: f32,
    /// Steepness at rest of Majd and Simaan's law.
    pub steepness: f32,
    /// The way in which Hayward and Armstrong's contact yields.
    pub adhesion: Adhesion,
}

impl Default for Settings {
    fn default() -> Self {
        Self::brass()
    }
}
