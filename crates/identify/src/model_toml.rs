//! `model.toml`: a model as people read it, and as the device takes it.
//!
//! ```toml
//! [preset]                 # each line is `set KEY VALUE` on the device's console
//! law = "karnopp"
//! mass = 0.3886            # kg
//! f_static_p = 3.8513      # N
//! stribeck.force_p = 0.2   # an effect beside the law: EFFECT.PARAMETER
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
//! ```
//!
//! A file without sections is read as `[preset]`. `f_static`, `f_dynamic` and `damping` stand for both directions.

use crate::error::Place;
use crate::model::{Coupling, Model};
use crate::{Error, Geometry, SensorEffect, model_read};
use friction::effects::Effect;
use friction::{Invalid, Law};
use std::fmt::Write;
use std::path::Path;

/// Name and version of the file.
pub const MODEL_SCHEMA: &str = "tribos.model/1";

/// What is wrong with a text, and where: line and column from 1.
#[derive(Debug)]
pub(crate) struct Complaint {
    pub at: Option<(usize, usize)>,
    pub why: String,
}

impl Complaint {
    fn of(self, file: &str) -> Error {
        let place = self.at.map_or_else(Place::default, |(line, column)| Place {
            line: Some(line as u64),
            column: Some((column, String::new())),
        });
        Error::Input {
            file: file.to_string(),
            place,
            value: String::new(),
            accepted: format!(": {}", self.why),
        }
    }
}

impl Model {
    /// Reads `model.toml`.
    ///
    /// # Errors
    /// A file that cannot be read, is not TOML, or holds a value that is not accepted: file, line and column.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|e| Error::File { file: file.clone(), why: e.to_string() })?;
        Self::from_toml(&file, &text)
    }

    /// Reads the text of a `model.toml`; `file` stands for the file in messages.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn from_toml(file: &str, text: &str) -> Result<Self, Error> {
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
        std::fs::write(path, self.to_toml()).map_err(|e| Error::File { file, why: e.to_string() })
    }

    /// What the device takes: name and value of every `set`, in an order it accepts.
    #[must_use]
    pub fn preset_lines(&self) -> Vec<(String, String)> {
        let mut out = vec![("law".to_string(), self.law.id().to_string())];
        let mut set = |name: &str, value: f64| out.push((name.to_string(), decimal(value)));
        set("mass", self.mass);
        for (name, value) in law_parameters(&self.law) {
            // A Δv that is not known is the device's choice: it refuses zero.
            if name != "dv" || value > 0.0 {
                set(name, value);
            }
        }
        for effect in &self.effects {
            for parameter in effect.kind.gains().iter().chain(effect.kind.shape()) {
                if let Some(value) = effect.get(parameter.name) {
                    set(&format!("{}.{}", effect.kind.id(), parameter.name), value);
                }
            }
        }
        let Coupling { renderer, k_vc, b_vc } = &self.coupling;
        if let Some(k) = k_vc {
            set("k_vc", *k);
        }
        if let Some(b) = b_vc {
            set("b_vc", *b);
        }
        if let Some(renderer) = renderer {
            out.insert(1, ("renderer".into(), renderer.clone()));
        }
        out
    }

    /// The text of `model.toml`; [`Model::from_toml`] gives back an equal model.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = String::from("[preset] # each line is `set KEY VALUE` on the device's console\n");
        for (name, value) in self.preset_lines() {
            let value = if matches!(name.as_str(), "law" | "renderer") { quoted(&value) } else { value };
            let unit = unit_of(&name, self.geometry);
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
        let force = if axis { "N·m" } else { "N" };
        let n = &self.nuisances;
        let _ = writeln!(text, "offset = {} # {force}, added by the force channel", decimal(n.offset));
        let _ = writeln!(text, "delay_s = {} # s, force behind position", decimal(n.delay_s));
        if let Some(cutoff) = self.cutoff_hz {
            let _ = writeln!(text, "cutoff_hz = {} # Hz, zero-phase filter of a prediction", decimal(cutoff));
        }
        for sensor in &n.sensors {
            let (id, parameters) = sensor.parts();
            for (name, value) in parameters {
                let _ = writeln!(text, "{id}.{name} = {}", decimal(value));
            }
        }
        if !self.std.is_empty() {
            text.push_str("\n[std] # standard deviations\n");
            for (name, value) in &self.std {
                let _ = writeln!(text, "{} = {}", quoted(name), decimal(*value));
            }
        }
        text
    }
}

/// Shortest decimal that reads back as the same number; TOML wants a point or an exponent in a float.
fn decimal(value: f64) -> String {
    let text = format!("{value:?}");
    if text.contains(['.', 'e', 'n']) { text } else { format!("{text}.0") }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}

/// Parameters of a law by their name in a preset.
pub(crate) fn law_parameters(law: &Law<f64>) -> Vec<(&'static str, f64)> {
    match *law {
        Law::Karnopp(k) => vec![
            ("f_static_p", k.d_p),
            ("f_static_n", k.d_n),
            ("f_dynamic_p", k.c_p),
            ("f_dynamic_n", k.c_n),
            ("damping_p", k.b_p),
            ("damping_n", k.b_n),
            ("dv", k.delta_v),
        ],
        Law::Coulomb(c) => vec![
            ("f_static_p", c.static_p),
            ("f_static_n", c.static_n),
            ("f_dynamic_p", c.level_p),
            ("f_dynamic_n", c.level_n),
            ("damping_p", c.viscous_p),
            ("damping_n", c.viscous_n),
        ],
        Law::Dahl(d) => vec![
            ("f_dynamic_p", d.limit_p),
            ("f_dynamic_n", d.limit_n),
            ("damping", d.viscous),
            ("sigma", d.sigma),
        ],
        Law::LuGre(l) => vec![
            ("f_static", l.stiction),
            ("f_dynamic", l.coulomb),
            ("damping", l.sigma_2),
            ("sigma", l.sigma_0),
            ("sigma_1", l.sigma_1),
            ("stribeck_velocity", l.stribeck_velocity),
        ],
    }
}

/// A refusal in the words of the file instead of the law's.
pub(crate) fn name_in_file(law: &Law<f64>, refused: Invalid) -> Invalid {
    let parameter = match (law.id(), refused.parameter) {
        (_, "c_p" | "limit_p" | "level_p") => "f_dynamic_p",
        (_, "c_n" | "limit_n" | "level_n") => "f_dynamic_n",
        (_, "d_p" | "static_p") => "f_static_p",
        (_, "d_n" | "static_n") => "f_static_n",
        (_, "b_p" | "viscous_p") => "damping_p",
        (_, "b_n" | "viscous_n") => "damping_n",
        (_, "delta_v") => "dv",
        ("dahl", "viscous") | ("lugre", "sigma_2") => "damping",
        ("lugre", "sigma_0") => "sigma",
        ("lugre", "coulomb") => "f_dynamic",
        ("lugre", "stiction") => "f_static",
        (_, other) => other,
    };
    Invalid { parameter, ..refused }
}

/// Unit of a line of `[preset]`.
fn unit_of(name: &str, geometry: Geometry) -> &'static str {
    let units = crate::identification::Units::of(geometry);
    match name {
        "mass" => units.parameter("mass"),
        "f_static" | "f_static_p" | "f_static_n" | "f_dynamic" | "f_dynamic_p" | "f_dynamic_n" => {
            units.force()
        }
        "damping" | "damping_p" | "damping_n" | "sigma_1" | "b_vc" => units.parameter("viscous"),
        "dv" | "stribeck_velocity" => units.velocity(),
        "sigma" | "k_vc" => units.parameter("sigma"),
        _ => "",
    }
}

/// Effects a model may carry in `[model]`, for messages.
pub(crate) fn sensor_words() -> String {
    let ids: Vec<String> = SensorEffect::ALL
        .iter()
        .flat_map(|(id, names)| names.iter().map(move |name| format!("{id}.{name}")))
        .collect();
    ids.join(", ")
}

/// The middle of an effect's shape, and no force: what a file that names only some parameters leaves.
pub(crate) fn silent(kind: friction::effects::EffectKind) -> Effect<f64> {
    let mut effect = Effect { kind, gains: Default::default(), shape: Default::default() };
    for (value, parameter) in effect.shape.iter_mut().zip(kind.shape()) {
        let (min, max) = (parameter.min, parameter.max);
        *value = if min > 0.0 { (min * max).sqrt() } else { 0.5 * (min + max) };
    }
    effect
}
