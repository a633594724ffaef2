//! Key words of `model.toml`, shared by reader and writer.

use friction::effects::SeriesKind;
use friction::{Invalid, Law};
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
