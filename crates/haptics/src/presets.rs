//! Built-in presets: the materials of [thesis, table 3-3], run 1, and viscous damping of [thesis, table 5-2].
//!
//! The coupling is not from a source. 8 000 N/m is within the bound of [thesis, eq. 4.18] extended by B (33 000 N/m with
//! 15 N·s/m); K·1.5T < b + B holds even with a whole period of delay and a device of 1 N·s/m. The limit-cycle velocities of
//! [thesis, eq. 4.35] are 0.6 to 4.6 mm/s, all below Δv of [thesis, table 3-3].

use crate::Device;
use crate::settings::{LawKind, MAX_EFFECTS, RendererKind, Settings};
use friction::Adhesion;

/// Makes a preset.
pub type Make = fn() -> Settings;

impl Settings {
    /// The same contact at the scale of another device: forces as shares of the largest force, speeds of the overspeed, mass and
    /// coupling of the inertia. Softer until it is stable there; `None` if it is not at a thousandth of the stiffness either.
    #[must_use]
    pub fn scaled_to(&self, device: &Device) -> Option<Self> {
        let mut scaled = Self {
            f_static_p: device.force(self.f_static_p),
            f_static_n: device.force(self.f_static_n),
            f_dynamic_p: device.force(self.f_dynamic_p),
            f_dynamic_n: device.force(self.f_dynamic_n),
            damping_p: device.inertia(self.damping_p),
            damping_n: device.inertia(self.damping_n),
            dv: device.speed(self.dv),
            mass: device.inertia(self.mass),
            k_vc: device.inertia(self.k_vc),
            b_vc: device.inertia(self.b_vc),
            sigma: device.inertia(self.sigma),
            sigma_1: device.inertia(self.sigma_1),
            stribeck_velocity: device.speed(self.stribeck_velocity),
            attraction: device.force(self.attraction),
            effects: [None; MAX_EFFECTS],
            ..*self
        };
        for _ in 0..10 {
            if scaled.validate(device).is_ok() {
                return Some(scaled);
            }
            for softer in [&mut scaled.k_vc, &mut scaled.b_vc, &mut scaled.sigma, &mut scaled.sigma_1] {
                *softer *= 0.5;
            }
        }
        None
    }

    /// Common part of the presets: the coupling, and parameters of other laws.
    const fn karnopp(levels: [f32; 6], dv: f32, mass: f32) -> Self {
        let [f_static_p, f_static_n, f_dynamic_p, f_dynamic_n, damping_p, damping_n] = levels;
        Self {
            law: LawKind::Karnopp,
            renderer: RendererKind::VirtualCoupling,
            f_static_p,
            f_static_n,
            f_dynamic_p,
            f_dynamic_n,
            damping_p,
            damping_n,
            dv,
            mass,
            k_vc: 8_000.0,
            b_vc: 15.0,
            sigma: 10_000.0,
            sigma_1: 10.0,
            stribeck_velocity: 0.01,
            effects: [None; MAX_EFFECTS],
            passivity: false,
            elastic: 0.7,
            attraction: 3_000.0,
            memory: 0.0,
            dwell: 1.0,
            steepness: 10.0,
            adhesion: Adhesion::StickSlide,
        }
    }

    /// Aluminium on brass ([thesis, table 3-3], run 1).
    #[must_use]
    pub const fn brass() -> Self {
        Self {
            sigma: 30_000.0,
            ..Self::karnopp([2.1302, 1.8623, 1.7714, 1.729, 0.457, 0.6196], 0.007, 0.4033)
        }
    }

    /// Aluminium on Teflon ([thesis, table 3-3], run 1).
    #[must_use]
    pub const fn teflon() -> Self {
        Self {
            sigma: 10_000.0,
            ..Self::karnopp([1.0078, 0.7167, 0.513, 0.5365, 1.0957, 1.3038], 0.005, 0.4436)
        }
    }

    /// Aluminium on rubber ([thesis, table 3-3], run 1).
    #[must_use]
    pub const fn rubber() -> Self {
        Self {
            sigma: 50_000.0,
            ..Self::karnopp([3.8513, 2.9099, 3.4901, 2.5611, 8.7338, 7.9521], 0.02, 0.3886)
        }
    }

    /// The reference of the forced-choice experiment [thesis, table 5-3]: its Δv of 1 mm/s is below its limit cycle.
    #[must_use]
    pub const fn forced_choice() -> Self {
        Self { k_vc: 25_000.0, b_vc: 10.0, ..Self::karnopp([2.0, 2.0, 2.0, 2.0, 20.0, 20.0], 1e-3, 0.5) }
    }

    /// Viscous, 35 N·s/m and 0.5 kg, no dry friction [thesis, table 5-2].
    #[must_use]
    pub const fn viscous() -> Self {
        Self::karnopp([0.0, 0.0, 0.0, 0.0, 35.0, 35.0], 1e-4, 0.5)
    }

    /// The presets by name.
    pub const PRESETS: &'static [(&'static str, Make)] = &[
        ("brass", Self::brass),
        ("teflon", Self::teflon),
        ("rubber", Self::rubber),
        ("viscous", Self::viscous),
    ];

    /// The preset with this name.
    #[must_use]
    pub fn preset(name: &str) -> Option<Self> {
        Self::PRESETS.iter().find(|(known, _)| *known == name).map(|(_, make)| make())
    }
}
