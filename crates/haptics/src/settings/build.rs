//! Builds the configuration of the loop from settings.

#[cfg(feature = "admittance")]
use super::LawKind;
use super::Settings;
use crate::{Config, Device, Refused};
use friction::{Law, Surface};

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
        let surface = Surface {
            static_p: self.f_static_p,
            static_n: self.f_static_n,
            dynamic_p: self.f_dynamic_p,
            dynamic_n: self.f_dynamic_n,
            damping_p: self.damping_p,
            damping_n: self.damping_n,
            dv: self.dv,
            sigma: self.sigma,
            sigma_1: self.sigma_1,
            exponent: 1.0,
            stribeck_velocity: self.stribeck_velocity,
            elastic: self.elastic,
            attraction: self.attraction,
            memory: self.memory,
            dwell: self.dwell,
            steepness: self.steepness,
            adhesion: self.adhesion,
        };
        surface.law(self.law)
    }
}
