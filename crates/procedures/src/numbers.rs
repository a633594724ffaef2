//! Numbers as people type them, with what is accepted.

/// A cut-off: finite and above zero.
///
/// # Errors
/// What is accepted.
pub fn cutoff(text: &str) -> Result<f64, String> {
    positive(text, "a frequency in Hz", 1e6)
}

/// A noise level: finite and above zero.
///
/// # Errors
/// What is accepted.
pub fn noise(text: &str) -> Result<f64, String> {
    positive(text, "a standard deviation in N (or N·m)", 1e6)
}

/// Finite, above zero and up to `most`.
///
/// # Errors
/// `what`, and the range.
pub fn positive(text: &str, what: &str, most: f64) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(v) if v.is_finite() && v > 0.0 && v <= most => Ok(v),
        _ => Err(format!("{what}, above 0 and up to {most}, is accepted")),
    }
}
