//! Result of an identification on the device, and the preset made of it.

use crate::number::Text;
use crate::{Device, LawKind, Settings};
use core::fmt;
use friction::Scalar;

/// A parameter with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// Value.
    pub value: f32,
    /// Standard deviation.
    pub std: f32,
}

/// Result of an identification on the device. Levels are magnitudes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identified {
    /// m, kg.
    pub mass: Estimate,
    /// C_p, N.
    pub coulomb_p: Estimate,
    /// b_p, N·s/m.
    pub viscous_p: Estimate,
    /// C_n, N.
    pub coulomb_n: Estimate,
    /// b_n, N·s/m.
    pub viscous_n: Estimate,
    /// D_p, N: friction while the handle leaves rest and is slower than Δv. `None`: it was not seen to leave rest.
    pub static_p: Option<Estimate>,
    /// D_n, N.
    pub static_n: Option<Estimate>,
    /// Δv, m/s.
    pub delta_v: Estimate,
    /// Mass by plain least squares on the accelerometer [thesis, eq. 3.8], kg: what its noise would have made of it.
    pub mass_least_squares: f32,
    /// True acceleration over accelerometer reading.
    pub accel_scale: f32,
    /// Added to the scaled reading, m/s².
    pub accel_offset: f32,
    /// ‖e‖/‖F‖ over the samples used.
    pub relative_error: f32,
    /// Samples used.
    pub used: u32,
    /// Number of samples excluded as too slow.
    pub set_aside: u32,
}

impl Identified {
    /// A preset of what was found: a Karnopp block with the coupling of `base`. Levels are kept physical and
    /// within what `device` can hold; `Settings::validate` has the last word.
    #[must_use]
    pub fn to_settings(&self, base: &Settings, device: &Device) -> Settings {
        let level = |x: f32| Scalar::clamp(x, 0.0, device.force_max);
        let fixed =
            |x: Option<Estimate>, dynamic: f32| Scalar::max(level(x.map_or(0.0, |d| d.value)), dynamic);
        let (f_dynamic_p, f_dynamic_n) = (level(self.coulomb_p.value), level(self.coulomb_n.value));
        Settings {
            law: LawKind::Karnopp,
            f_dynamic_p,
            f_dynamic_n,
            f_static_p: fixed(self.static_p, f_dynamic_p),
            f_static_n: fixed(self.static_n, f_dynamic_n),
            damping_p: self.viscous_p.value,
            damping_n: self.viscous_n.value,
            dv: self.delta_v.value,
            mass: self.mass.value,
            ..*base
        }
    }
}

/// Reason of a refusal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unidentified {
    /// Too few samples of fast motion in one direction.
    TooLittleMotion {
        /// Fast samples of positive motion.
        positive: u32,
        /// Fast samples of negative motion.
        negative: u32,
    },
    /// The accelerometer does not follow the differentiated velocity.
    Accelerometer {
        /// Correlation of the two.
        correlation: f32,
    },
    /// The motion does not tell this parameter from the others.
    NotIdentifiable(&'static str),
}

impl fmt::Display for Unidentified {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLittleMotion { positive, negative } => write!(
                f,
                "too little motion: {positive} samples forward and {negative} back are fast; 50 each are needed"
            ),
            Self::Accelerometer { correlation } => write!(
                f,
                "the accelerometer does not follow the motion (correlation {:.3}, at least 0.8 is needed)",
                Text(*correlation)
            ),
            Self::NotIdentifiable(name) => write!(f, "{name} cannot be told from the others by this motion"),
        }
    }
}

impl core::error::Error for Unidentified {}
