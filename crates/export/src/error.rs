//! Why a model cannot be exported.

/// Why a model cannot be exported; one line.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A parameter that the format does not take.
    #[error("{parameter} = {value}: {accepted}")]
    Parameter {
        /// Name.
        parameter: &'static str,
        /// Value.
        value: f64,
        /// What would be accepted.
        accepted: String,
    },
    /// A slide of URDF has limits, and a model has none.
    #[error(
        "URDF needs the limits of a slide, and a model has none; accepted with a recording, which has a stroke"
    )]
    NoLimits,
    /// BAM models servos, and the model is of a slide.
    #[error(
        "BAM holds the axis of a servo, and the model is of a slide; accepted is a model with geometry = \"rotary\""
    )]
    NotAnAxis,
    /// The recording cannot be predicted.
    #[error(transparent)]
    Recording(#[from] signals::Error),
}
