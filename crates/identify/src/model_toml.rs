//! Writer of `model.toml`, which people read and the device accepts.
//!
//! ```toml
//! [preset]                 # each line is `set KEY VALUE` on the device's console
//! law = "karnopp"
//! mass = 0.3886            # kg
//! f_static_p = 3.8513      # N
//! stribeck.force_p = 0.2   # an effect beside the law: EFFECT.PARAMETER; a second wavelength: cogging_2
//!
//! [model]                  # what only the host needs; all of it optional
//! schema = "tribos.model/1"
//! name = "rubber"
//! geometry = "linear"      # or "rotary": then N is N·m, m is rad, kg is kg·m²
//! exponent = 1.0           # of Dahl's law; devices use 1
//! offset = 0.01            # N, added by the force channel
//! delay_s = 0.0            # s, force behind position
//! cutoff_hz = 40.0         # Hz, of the zero-phase filter of a prediction
//! saturation.share = -1.0  # further effects of sensors and drive
//! saturation.limit = 9.0
//!
//! [std]                    # standard deviations, by the names of [preset]
//! mass = 0.0045
//!
//! [[curve]]                # free forms: physics without a name
//! ```
//!
//! A file without sections is read as `[preset]`. `f_static`, `f_dynamic` and `damping` stand for both directions.

use crate::identification::unit_of;
use crate::model::{Coupling, Model};
use crate::model_words::{Complaint, MODEL_SCHEMA, decimal, name_in_file};
use crate::planar::PlanarModel;
use crate::{model_curves, model_read};
use friction::effects::EffectName;
use friction::parameters::OFFSET;
use friction::{Dimension, Law, Surface};
use signals::files::reason;
use signals::{Error, Geometry};
use std::fmt::Write;
use std::path::Path;

impl Model {
    /// Reads `model.toml`.
    ///
    /// # Errors
    /// A file that cannot be read, is not TOML, or holds a value that is not accepted: file, line and column.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text =
            std::fs::read_to_string(path).map_err(|e| Error::File { file: file.clone(), why: reason(&e) })?;
        Self::from_toml(&file, &text)
    }

    /// Reads the text of a `model.toml`; `file` stands for the file in messages.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn from_toml(file: &str, text: &str) -> Result<Self, Error> {
        if PlanarModel::is_planar(text) {
            let why = "is a model in the plane; accepted is one on a line: `predict` and `compare` take it, or identify one axis \
                       of its recording with --map time_s=time_s,position_m=position_x_m,force_n=force_x_n";
            return Err(Complaint { at: None, why: why.into() }.of(file));
        }
        model_read::read(text).map_err(|complaint| complaint.of(file))
    }

    /// Writes `model.toml`.
    ///
    /// # Errors
    /// A file that cannot be written, or a model that is not valid.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let file = path.as_ref().display().to_string();
        if let Err(refused) = self.validate() {
            return Err(Complaint { at: None, why: name_in_file(&self.law, refused).to_string() }.of(&file));
        }
        std::fs::write(path, self.to_toml()).map_err(|e| Error::File { file, why: reason(&e) })
    }

    /// What the device takes: name and value of every `set`, in an order it accepts.
    #[must_use]
    pub fn preset_lines(&self) -> Vec<(String, String)> {
        let mut out = vec![("law".to_string(), self.law.id().to_string())];
        let mut set = |name: &str, value: f64| out.push((name.to_string(), decimal(value)));
        set("mass", self.mass);
        let surface = Surface::of(&self.law);
        for name in self.law.kind().parameters() {
            // A Δv that is not known is the device's choice: it refuses zero.
            if let Some(value) = surface.get(name).filter(|value| *name != "dv" || *value > 0.0) {
                set(name, value);
            }
        }
        for (name, effect) in EffectName::of(self.effects.iter()) {
            for parameter in effect.kind.gains().iter().chain(effect.kind.shape()) {
                if let Some(value) = effect.get(parameter.name) {
                    set(&format!("{name}.{}", parameter.name), value);
                }
            }
        }
        let Coupling { renderer, k_vc, b_vc, passivity } = &self.coupling;
        if let Some(k) = k_vc {
            set("k_vc", *k);
        }
        if let Some(b) = b_vc {
            set("b_vc", *b);
        }
        if let Some(renderer) = renderer {
            out.insert(1, ("renderer".into(), renderer.clone()));
        }
        if self.law.kind().takes("adhesion") {
            out.push(("adhesion".into(), surface.adhesion.id().into()));
        }
        if let Some(passivity) = passivity {
            out.push(("passivity".into(), passivity.clone()));
        }
        out
    }

    /// The text of `model.toml`; [`Model::from_toml`] gives back an equal model.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = String::from("[preset] # each line is `set KEY VALUE` on the device's console\n");
        for (name, value) in self.preset_lines() {
            let value = if matches!(name.as_str(), "law" | "renderer" | "adhesion" | "passivity") {
                quoted(&value)
            } else {
                value
            };
            let unit = match name.split_once('.') {
                Some((effect, parameter)) => effect_unit(effect, parameter, self.geometry),
                None => unit_of(&name, self.geometry),
            };
            let _ = if unit.is_empty() {
                writeln!(text, "{name} = {value}")
            } else {
                writeln!(text, "{name} = {value} # {unit}")
            };
        }
        let axis = self.geometry == Geometry::Rotary;
        let _ = write!(
            text,
            "\n[model] # what only the host needs\nschema = {}\nname = {}\ngeometry = \"{}\"\n",
            quoted(MODEL_SCHEMA),
            quoted(&self.name),
            if axis { "rotary" } else { "linear" }
        );
        if let Law::Dahl(law) = &self.law {
            let _ =
                writeln!(text, "exponent = {} # shape of Dahl's law; devices use 1", decimal(law.exponent));
        }
        let force = Dimension::FORCE.unit(self.geometry);
        let n = &self.nuisances;
        let _ =
            writeln!(text, "{} = {} # {force}, added by the force channel", OFFSET.name, decimal(n.offset));
        let _ = writeln!(text, "delay_s = {} # s, force behind position", decimal(n.delay_s));
        if let Some(cutoff) = self.cutoff_hz {
            let _ = writeln!(text, "cutoff_hz = {} # Hz, zero-phase filter of a prediction", decimal(cutoff));
        }
        for sensor in &n.sensors {
            let id = sensor.kind.about().id;
            for (parameter, value) in sensor.parameters() {
                let unit = parameter.unit(self.geometry);
                let _ = writeln!(text, "{id}.{} = {} # {unit}", parameter.name, decimal(value));
            }
        }
        if !self.std.is_empty() {
            text.push_str("\n[std] # standard deviations\n");
            for (name, value) in &self.std {
                let _ = writeln!(text, "{} = {}", quoted(name), decimal(*value));
            }
        }
        text.push_str(&model_curves::write(&self.curves));
        text
    }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}

/// Unit of a parameter of an effect.
fn effect_unit(effect: &str, parameter: &str, geometry: Geometry) -> String {
    let name = EffectName::parse(effect);
    let of = name.and_then(|name| name.kind.about().parameters().find(|p| p.name == parameter));
    of.map_or_else(String::new, |p| p.unit(geometry).to_string())
}
