//! The force a model predicts for a recording, and what to know about it.

use crate::error::Result;
use crate::recordings::model_name;
use identify::Model;
use signals::Recording;

/// A prediction.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// Force at every sample of the recording, N or N·m; NaN where the velocity is not known.
    pub force: Vec<f64>,
    /// What a user should know, each one line.
    pub notes: Vec<String>,
    /// Root mean square of the unfiltered residual, and its share of the force; None where no force was measured.
    pub residual: Option<(f64, f64)>,
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
    let force = model.predict(recording)?;
    let (mut error, mut square, mut count) = (0.0, 0.0, 0);
    for (p, f) in force.iter().zip(&recording.force) {
        if f.is_finite() && p.is_finite() {
            (error, square, count) = (error + (f - p) * (f - p), square + f * f, count + 1);
        }
    }
    let unknown = force.iter().filter(|p| p.is_nan()).count();
    if unknown > 0 {
        notes.push(format!(
            "{unknown} of {} samples are predicted as NaN: they lie in or between gaps of more than four samples, and \
             their velocity is not known",
            force.len()
        ));
    }
    let residual =
        (count > 0 && square > 0.0).then(|| ((error / f64::from(count)).sqrt(), f64::sqrt(error / square)));
    Ok(Predicted { force, notes, residual })
}
