//! Builds the configuration of the loop from settings.

use super::{LawKind, Settings};
use crate::{Config, Device, Refused};
use friction::{Coulomb, Dahl, Karnopp, Law, LuGre};

impl Settings {
    /// Validates, then builds the configuration. Warnings are ignored; see [`Settings::validate`].
    ///
    /// # Errors
    /// [`Refused`]: the first refused parameter, with the number that would be accepted.
    pub fn build(&self, device: &Device) -> Result<Config, Refused> {
        self.validate(device)?;
        Ok(Config::new(self, device))
    }

    /// The law as the renderer steps it. The admittance renderer takes the levels of Karnopp's law without its dead band.
    #[cfg(feature = "admittance")]
    pub(crate) fn rendered_law(&self) -> Law<f32> {
        let levels = self.renderer == super::RendererKind::Admittance && self.law == LawKind::Karnopp;
        Self { law: if levels { LawKind::Coulomb } else { self.law }, ..*self }.friction_law()
    }

    /// The law as the renderer steps it.
    #[cfg(not(feature = "admittance"))]
    pub(crate) fn rendered_law(&self) -> Law<f32> {
        self.friction_law()
    }

    /// The law with these parameters.
    #[must_use]
    pub fn friction_law(&self) -> Law<f32> {
        match self.law {
            LawKind::Karnopp => Law::Karnopp(Karnopp {
                c_p: self.f_dynamic_p,
                c_n: self.f_dynamic_n,
                b_p: self.damping_p,
                b_n: self.damping_n,
                d_p: self.f_static_p,
                d_n: self.f_static_n,
                delta_v: self.dv,
            }),
            LawKind::Dahl => Law::Dahl(Dahl {
                limit_p: self.f_dynamic_p,
                limit_n: self.f_dynamic_n,
                sigma: self.sigma,
                exponent: 1.0,
                viscous: self.damping_p,
            }),
            LawKind::Coulomb => Law::Coulomb(Coulomb {
                level_p: self.f_dynamic_p,
                level_n: self.f_dynamic_n,
                static_p: self.f_static_p,
                static_n: self.f_static_n,
                viscous_p: self.damping_p,
                viscous_n: self.damping_n,
            }),
            LawKind::LuGre => Law::LuGre(LuGre {
                sigma_0: self.sigma,
                sigma_1: self.sigma_1,
                sigma_2: self.damping_p,
                coulomb: self.f_dynamic_p,
                stiction: self.f_static_p,
                stribeck_velocity: self.stribeck_velocity,
            }),
        }
    }
}
