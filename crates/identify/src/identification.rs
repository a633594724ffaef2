//! Result of an identification: the fixed JSON, including the parameters that the recording does not determine.

use friction::parameters;
use serde::{Deserialize, Serialize};
use signals::{Geometry, Preparation, RecordingFault};
use std::collections::BTreeMap;

/// Name and version of the JSON.
pub const SCHEMA: &str = "tribos.identification/1";

/// One parameter with its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Value, in `unit`. Levels are magnitudes.
    pub value: f64,
    /// Standard deviation, in `unit`. Counts the samples for what they are worth: residuals that follow each other
    /// (a filter, physics left out) make it larger.
    pub std: f64,
    /// SI unit.
    pub unit: String,
    /// 95 % confidence interval. Not symmetric for a parameter that is fitted on a logarithmic scale.
    pub ci95: [f64; 2],
    /// Standard deviation as if every residual were independent of the next: the textbook formula, for comparison
    /// with published figures. Absent where that formula does not apply.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_white: Option<f64>,
}

impl Estimate {
    /// A parameter whose error is Gaussian.
    #[must_use]
    pub fn gaussian(value: f64, std: f64, unit: impl Into<String>) -> Self {
        Self {
            value,
            std,
            unit: unit.into(),
            ci95: [value - 1.96 * std, value + 1.96 * std],
            std_white: None,
        }
    }
}

/// A parameter this recording does not determine. It has no number, on purpose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NotIdentifiable {
    /// Its name.
    pub parameter: String,
    /// Why, with the bound that can be given where one can.
    pub because: String,
    /// The move that would determine it: a line for the device's console.
    pub experiment: String,
}

/// A law identified from a recording. Serialises as `tribos.identification/1`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// [`SCHEMA`].
    pub schema: String,
    /// Law id: `karnopp` or `dahl`.
    pub law: String,
    /// Samples fitted.
    pub samples: usize,
    /// ‖e‖/‖F‖ over the samples fitted.
    pub relative_error: f64,
    /// Parameters by name.
    pub parameters: BTreeMap<String, Estimate>,
    /// What the recording does not determine.
    pub not_identifiable: Vec<NotIdentifiable>,
    /// What the audit found: faults of the recording, not physics.
    pub recording_faults: Vec<RecordingFault>,
    /// What was done to each recording before the fit.
    #[serde(default)]
    pub preparation: Vec<Preparation>,
    /// Unit of the force: N, or N·m on an axis.
    pub force_unit: String,
    /// Root mean square of the residual over the samples fitted, in `force_unit`.
    pub residual_rms: f64,
    /// 1 − Σe²/Σ(F − mean F)² over the samples fitted.
    pub r_squared: f64,
    /// How the numbers were found, in words.
    pub estimator: String,
    /// How the signals were prepared, in words.
    pub preprocess: String,
    /// Names of the parameters the matrix below is about, in its order.
    pub correlation_of: Vec<String>,
    /// Correlation of the errors of the parameters fitted together.
    pub correlation: Vec<Vec<f64>>,
    /// Independent samples the residual is worth: fewer than `samples` where residuals follow each other.
    pub effective_samples: f64,
}

impl Identification {
    /// Value of a parameter, if it was identified.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        self.parameters.get(name).map(|p| p.value)
    }

    /// The JSON, indented.
    ///
    /// # Errors
    /// None in practice: every field can be written.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }
}

/// Unit of a parameter of a body, a law or a preset; empty for a name that is none of theirs.
pub(crate) fn unit_of(name: &str, geometry: Geometry) -> String {
    parameters::find(name).map_or_else(String::new, |p| p.unit(geometry).to_string())
}
