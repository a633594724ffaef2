//! A complete model of a sliding body: mass, law, effects, and the errors of its sensors.
//!
//! One model predicts a recording, runs in a simulation and is a preset of the device (`model.toml`, see
//! [`Model::to_toml`]).

use crate::Identification;
use friction::effects::{About, Effect, EffectName, SeriesEffect};
use friction::parameters::{DELAY, OFFSET};
use friction::{Coulomb, Dahl, Dimension, FreeForm, FrictionLaw, Invalid, Karnopp, Law, in_range};
use signals::Geometry;
use std::collections::BTreeMap;

/// What the measurement adds to the physics. A device that renders the model leaves it out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Nuisances {
    /// Constant that the force channel adds, N or N·m.
    pub offset: f64,
    /// Time by which the force channel is behind the position, s; negative when it is ahead.
    pub delay_s: f64,
    /// Further effects of sensors and drive.
    pub sensors: Vec<SeriesEffect>,
}

/// What a device needs beside the friction to render it; the virtual coupling of [thesis, eq. 4.22].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Coupling {
    /// `virtual_coupling`, `stopping_force` or `impedance`; the device keeps its own when absent.
    pub renderer: Option<String>,
    /// Stiffness, N/m; the device keeps its own when absent.
    pub k_vc: Option<f64>,
    /// Damping, N·s/m; the device keeps its own when absent.
    pub b_vc: Option<f64>,
    /// `on` or `off`: the passivity controller; the device keeps its own when absent.
    pub passivity: Option<String>,
}

/// A sliding body, as identified or diagnosed.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Name, as a preset would be called.
    pub name: String,
    /// Whether the numbers are of a slide (N, m, kg) or of an axis (N·m, rad, kg·m²).
    pub geometry: Geometry,
    /// Moving mass, kg, or inertia, kg·m².
    pub mass: f64,
    /// Friction law, f64 and SI.
    pub law: Law<f64>,
    /// Effects beside the law, each at most once.
    pub effects: Vec<Effect<f64>>,
    /// Physics without a name: curves and maps over coordinates of the motion.
    pub curves: Vec<FreeForm<f64>>,
    /// What the sensors add.
    pub nuisances: Nuisances,
    /// How the device should couple it to the handle.
    pub coupling: Coupling,
    /// Cut-off of the zero-phase filter behind which velocity and acceleration are derived for a prediction, Hz.
    /// None: the default of [`crate::prepare`].
    pub cutoff_hz: Option<f64>,
    /// Standard deviations of parameters, by the name they have in the file.
    pub std: BTreeMap<String, f64>,
}

impl Default for Model {
    /// A massless body without friction.
    fn default() -> Self {
        let zero = 0.0;
        Self {
            name: String::new(),
            geometry: Geometry::Linear,
            mass: zero,
            law: Law::Coulomb(Coulomb {
                level_p: zero,
                level_n: zero,
                static_p: zero,
                static_n: zero,
                viscous_p: zero,
                viscous_n: zero,
            }),
            effects: Vec::new(),
            curves: Vec::new(),
            nuisances: Nuisances::default(),
            coupling: Coupling::default(),
            cutoff_hz: None,
            std: BTreeMap::new(),
        }
    }
}

impl Model {
    /// Checks that every number is finite and physical.
    ///
    /// # Errors
    /// The first parameter that is not, with what would be accepted.
    pub fn validate(&self) -> Result<(), Invalid> {
        in_range("mass", self.mass, 0.0, 1e6)?;
        self.law.validate()?;
        self.effects.iter().try_for_each(Effect::validate)?;
        self.curves.iter().try_for_each(FreeForm::validate)?;
        in_range(OFFSET.name, self.nuisances.offset, -1e6, 1e6)?;
        in_range("delay_s", self.nuisances.delay_s, -1.0, 1.0)?;
        self.nuisances.sensors.iter().try_for_each(SeriesEffect::validate)?;
        if let Some(cutoff) = self.cutoff_hz {
            in_range("cutoff_hz", cutoff, 1e-3, 1e6)?;
        }
        if let Some(k) = self.coupling.k_vc {
            in_range("k_vc", k, 0.0, 1e9)?;
        }
        self.coupling.b_vc.map_or(Ok(()), |b| in_range("b_vc", b, 0.0, 1e6))
    }

    /// The effect of this name, added as a silent one if it is the next of its kind. None if its number skips one.
    pub fn effect_mut(&mut self, name: EffectName) -> Option<&mut Effect<f64>> {
        let of_kind = |e: &Effect<f64>| e.kind == name.kind;
        if self.effects.iter().filter(|e| of_kind(e)).count() == name.index {
            self.effects.push(Effect::silent(name.kind));
        }
        self.effects.iter_mut().filter(|e| of_kind(e)).nth(name.index)
    }

    /// Takes out what has a phase along the stroke, which holds only while the zero of the position does; returns the ids.
    pub fn without_phases(&mut self) -> Vec<&'static str> {
        let mut out = Vec::new();
        let mut stays = |about: &'static About| {
            let stays = about.wavelength().is_none();
            if !stays && !out.contains(&about.id) {
                out.push(about.id);
            }
            stays
        };
        self.effects.retain(|e| stays(e.kind.about()));
        self.nuisances.sensors.retain(|e| stays(e.kind.about()));
        out
    }
}

impl From<&Identification> for Model {
    /// What was identified. A parameter the recording does not determine takes the value that adds no physics: static
    /// friction the dynamic level, Δv zero, and the stiffness of a bristle such that it bends by ten micrometres
    /// (or microradians), which a hand feels as rigid.
    fn from(found: &Identification) -> Self {
        let of = |name: &str| found.value(name).filter(|v| v.is_finite());
        // A level that came out on the wrong side of zero is zero.
        let level = |name: &str| of(name).unwrap_or(0.0).max(0.0);
        let law = if found.law == "dahl" {
            let (limit_p, limit_n) = (level("limit_p"), level("limit_n"));
            let rigid = (limit_p.max(limit_n) / 1e-5).max(1.0);
            Law::Dahl(Dahl {
                limit_p,
                limit_n,
                sigma: of("sigma").unwrap_or(rigid),
                exponent: of("exponent").unwrap_or(1.0),
                viscous: of("viscous").unwrap_or(0.0),
            })
        } else {
            let (c_p, c_n) = (level("coulomb_p"), level("coulomb_n"));
            Law::Karnopp(Karnopp {
                c_p,
                c_n,
                b_p: of("viscous_p").unwrap_or(0.0),
                b_n: of("viscous_n").unwrap_or(0.0),
                // below the sliding level it is a step that the filter blurred away, and no device renders it
                d_p: of("static_p").unwrap_or(c_p).max(c_p),
                d_n: of("static_n").unwrap_or(c_n).max(c_n),
                delta_v: of("delta_v").unwrap_or(0.0).max(0.0),
            })
        };
        let axis = Dimension::FORCE.unit(Geometry::Rotary).to_string();
        let rotary = found.force_unit == axis;
        Self {
            geometry: if rotary { Geometry::Rotary } else { Geometry::Linear },
            mass: of("mass").unwrap_or(0.0).max(0.0),
            law,
            nuisances: Nuisances {
                offset: of(OFFSET.name).unwrap_or(0.0),
                delay_s: of(DELAY.name).unwrap_or(0.0),
                ..Nuisances::default()
            },
            std: found
                .parameters
                .iter()
                .filter(|(_, p)| p.std.is_finite())
                .map(|(name, p)| (preset_name(&found.law, name).to_string(), p.std))
                .collect(),
            ..Self::default()
        }
    }
}

/// Name in a preset of a parameter of an identification.
#[must_use]
pub fn preset_name<'a>(law: &str, name: &'a str) -> &'a str {
    match (law, name) {
        (_, "coulomb_p" | "limit_p") => "f_dynamic_p",
        (_, "coulomb_n" | "limit_n") => "f_dynamic_n",
        (_, "static_p") => "f_static_p",
        (_, "static_n") => "f_static_n",
        (_, "viscous_p") => "damping_p",
        (_, "viscous_n") => "damping_n",
        (_, "viscous") => "damping",
        (_, "delta_v") => "dv",
        _ => name,
    }
}
