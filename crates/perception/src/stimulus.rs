//! Stimuli: a rendered block, and the five resistances of [thesis, table 5-2].

use serde::{Deserialize, Serialize};

/// A rendered block with symmetric friction: the parameters of [thesis, table 5-3].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stimulus {
    /// Static friction F_s, N.
    pub f_static: f64,
    /// Dynamic friction F_d, N.
    pub f_dynamic: f64,
    /// Viscous damping b, N·s/m.
    pub damping: f64,
    /// Half-width of the stuck velocity band DV, m/s.
    pub dv: f64,
    /// Mass of the virtual block m, kg.
    pub mass: f64,
    /// Stiffness of the virtual coupling K_vc, N/m.
    pub k_vc: f64,
    /// Damping of the virtual coupling B_vc, N·s/m.
    pub b_vc: f64,
}

impl Stimulus {
    /// The reference of the forced choice [thesis, table 5-3].
    pub const REFERENCE: Self = Self {
        f_static: 2.0,
        f_dynamic: 2.0,
        damping: 20.0,
        dv: 0.001,
        mass: 0.5,
        k_vc: 25_000.0,
        b_vc: 10.0,
    };

    /// The same block with other levels of static and dynamic friction, N.
    #[must_use]
    pub const fn with_levels(self, f_static: f64, f_dynamic: f64) -> Self {
        Self { f_static, f_dynamic, ..self }
    }

    /// Names and values of all parameters, as in `set NAME VALUE` and preset files.
    #[must_use]
    pub fn parameters(&self) -> [(&'static str, f64); 7] {
        [
            ("f_static", self.f_static),
            ("f_dynamic", self.f_dynamic),
            ("damping", self.damping),
            ("dv", self.dv),
            ("mass", self.mass),
            ("k_vc", self.k_vc),
            ("b_vc", self.b_vc),
        ]
    }

    /// Checks every parameter against its physical range. A device may accept less.
    ///
    /// # Errors
    /// Parameter, value and accepted range.
    pub fn validate(&self) -> Result<(), String> {
        for (name, value) in self.parameters() {
            let positive = matches!(name, "mass" | "k_vc" | "dv");
            if !value.is_finite() || value < 0.0 || (positive && value == 0.0) {
                let from = if positive { "above 0" } else { "from 0 on" };
                return Err(format!("{name} = {value}: a finite number {from} is accepted"));
            }
        }
        Ok(())
    }
}

/// Resistance in the targeting task [thesis, table 5-2].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Resistance {
    /// The bare device: about 0.8 N and 1.4 kg on the printed one.
    Baseline,
    /// A real 0.5 kg block of aluminium on a rubber pad, about 3.5 N.
    Real,
    /// Rendered friction approximately equal to [`Resistance::Real`].
    Simulated,
    /// Like `Simulated`, with a static friction of about 7 N.
    HighStiction,
    /// Rendered viscous damping, about 35 N·s/m, 0.5 kg.
    Viscous,
}

impl Resistance {
    /// All five in the order of [thesis, table 5-2].
    pub const ALL: [Self; 5] =
        [Self::Baseline, Self::Real, Self::Simulated, Self::HighStiction, Self::Viscous];

    /// Name in [thesis, table 5-2].
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Real => "real friction",
            Self::Simulated => "simulated friction",
            Self::HighStiction => "high stiction",
            Self::Viscous => "viscous damping",
        }
    }

    /// Name in files, one word.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Real => "real",
            Self::Simulated => "simulated",
            Self::HighStiction => "high_stiction",
            Self::Viscous => "viscous",
        }
    }

    /// Rendered block. `None` for the bare device and for a real block.
    ///
    /// Friction levels (3.5 N, 7 N, 35 N·s/m) and mass are those of [thesis, table 5-2]. The coupling is that of the built-in
    /// presets; DV lies above the limit-cycle velocity of [thesis, eq. 4.35].
    #[must_use]
    pub fn rendered(self) -> Option<Stimulus> {
        let block = Stimulus {
            f_static: 3.5,
            f_dynamic: 3.5,
            damping: 0.0,
            dv: 0.01,
            mass: 0.5,
            k_vc: 8_000.0,
            b_vc: 15.0,
        };
        match self {
            Self::Baseline | Self::Real => None,
            Self::Simulated => Some(block),
            Self::HighStiction => Some(block.with_levels(7.0, 3.5)),
            Self::Viscous => Some(Stimulus { damping: 35.0, dv: 1e-4, ..block.with_levels(0.0, 0.0) }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_5_2_and_5_3_as_printed() {
        let levels = |r: Resistance| r.rendered().map(|s| (s.f_static, s.f_dynamic, s.damping, s.mass));
        assert_eq!(levels(Resistance::Baseline), None);
        assert_eq!(levels(Resistance::Real), None);
        assert_eq!(levels(Resistance::Simulated), Some((3.5, 3.5, 0.0, 0.5)));
        assert_eq!(levels(Resistance::HighStiction), Some((7.0, 3.5, 0.0, 0.5)));
        assert_eq!(levels(Resistance::Viscous), Some((0.0, 0.0, 35.0, 0.5)));
        let printed = [2.0, 2.0, 20.0, 0.001, 0.5, 25_000.0, 10.0];
        assert_eq!(Stimulus::REFERENCE.parameters().map(|(_, value)| value), printed);
    }

    #[test]
    fn invalid_blocks_name_the_parameter() {
        let bad = Stimulus { mass: 0.0, ..Stimulus::REFERENCE };
        assert_eq!(bad.validate(), Err("mass = 0: a finite number above 0 is accepted".into()));
        let bad = Stimulus { f_static: f64::NAN, ..Stimulus::REFERENCE };
        assert!(bad.validate().is_err());
    }
}
