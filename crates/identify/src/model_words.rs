//! Key words of `model.toml`, shared by reader and writer.

use friction::effects::SeriesKind;
use friction::{Invalid, LAWS, Law, LawKind, Surface};
use signals::{Error, Place};

/// Name and version of the file.
pub const MODEL_SCHEMA: &str = "tribos.model/1";

/// What is wrong with a text, and where: line and column from 1.
#[derive(Debug)]
pub(crate) struct Complaint {
    pub at: Option<(usize, usize)>,
    pub why: String,
}

impl Complaint {
    pub(crate) fn of(self, file: &str) -> Error {
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

/// Whether the law calls one of its parameters so.
fn is_of(law: &Law<f64>, parameter: &str) -> bool {
    let own = LAWS.iter().find(|(id, _)| *id == law.id());
    own.is_some_and(|(_, about)| about.parameters.iter().any(|p| p.name == parameter))
}

/// A refusal in the words of the file instead of the law's.
pub(crate) fn name_in_file(law: &Law<f64>, refused: Invalid) -> Invalid {
    let even = !matches!(law.kind(), LawKind::Karnopp | LawKind::Coulomb);
    let parameter = match refused.parameter {
        "c_p" | "limit_p" | "level_p" => "f_dynamic_p",
        "c_n" | "limit_n" | "level_n" => "f_dynamic_n",
        "d_p" | "static_p" => "f_static_p",
        "d_n" | "static_n" => "f_static_n",
        "b_p" | "viscous_p" => "damping_p",
        "b_n" | "viscous_n" => "damping_n",
        "delta_v" | "knee" => "dv",
        "viscous" | "sigma_2" if even => "damping",
        "sigma_0" | "stiffness" => "sigma",
        "coulomb" | "dynamic" | "level" => "f_dynamic",
        "stiction" => "f_static",
        // the rest of the static friction beyond the dynamic one
        own if is_of(law, own) && !Surface::<f64>::NAMES.contains(&own) => "f_static",
        "fallen" | "critical_velocity" => "stribeck_velocity",
        other => other,
    };
    Invalid { parameter, ..refused }
}

/// Effects a model may carry in `[model]`, for messages.
pub(crate) fn sensor_words() -> String {
    let ids: Vec<String> = SeriesKind::ALL
        .iter()
        .map(|kind| kind.about())
        .flat_map(|about| about.parameters().map(move |p| format!("{}.{}", about.id, p.name)))
        .collect();
    ids.join(", ")
}

/// Shortest decimal that reads back as the same number; TOML wants a point or an exponent in a float.
pub(crate) fn decimal(value: f64) -> String {
    let text = format!("{value:?}");
    if text.contains(['.', 'e', 'n']) { text } else { format!("{text}.0") }
}
