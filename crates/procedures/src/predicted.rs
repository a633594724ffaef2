//! The force a model predicts for a recording, and what to know about it.

use crate::error::Result;
use crate::prediction_errors::PredictionErrors;
use crate::recordings::model_name;
use identify::Model;
use signals::Recording;

/// A prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// Force at every sample of the recording, N or N·m; NaN where the velocity is not known.
    pub force: Vec<f64>,
    /// Standard deviation of it by what is not known of the motion, N or N·m.
    pub std: Vec<f64>,
    /// What a user should know, each one line.
    pub notes: Vec<String>,
    /// Where the error is.
    pub errors: PredictionErrors,
}

/// Predicts the force of a recording. Effects with a phase along the stroke are left out of a recording that the model was
/// not made of, unless the position is `absolute`.
///
/// # Errors
/// Those of [`Model::predict`].
pub fn predict(model: &Model, recording: &Recording, absolute: bool) -> Result<Predicted> {
    let mut model = model.clone();
    let mut notes = Vec::new();
    if !absolute && model.name != model_name(std::slice::from_ref(recording)) {
        let left_out = model.without_phases();
        if !left_out.is_empty() {
            notes.push(format!(
                "{} left out: a phase along the stroke holds only while the zero of the position does; \
                 `absolute` keeps it",
                left_out.join(", ")
            ));
        }
    }
    let identify::Predicted { force, std, is_sliding } = model.predict_with_std(recording)?;
    let errors = PredictionErrors::of(recording, &force, &is_sliding, model.cutoff_hz);
    let unknown = force.iter().filter(|p| p.is_nan()).count();
    if unknown > 0 {
        notes.push(format!(
            "{unknown} of {} samples are predicted as NaN: they lie in or between gaps of more than four samples, and \
             their velocity is not known",
            force.len()
        ));
    }
    Ok(Predicted { force, std, notes, errors })
}
