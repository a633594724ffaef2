//! The concealed-effect proof: effects hidden in recordings of a plant that shares no equation with the crates under
//! test, answers given without the labels, and the tables that come of comparing the two.
//!
//! ```text
//! motion    what the body is asked to do          hidden   what can be hidden in it
//! plant     implicit contact, own time stepping   sensors  what the channels make of it
//! cases     what is hidden where, and how much    seal     recordings and labels onto disk
//! answers   recordings in, diagnoses out: sees neither plan nor labels
//! score     answers against labels                tables   for people, and for machines
//! ```

pub(crate) mod answers;
pub(crate) mod cases;
mod hidden;
mod motion;
mod plant;
pub(crate) mod score;
pub(crate) mod seal;
mod sensors;
pub(crate) mod tables;

/// Ids of everything that can be hidden.
pub(crate) fn effects() -> Vec<&'static str> {
    hidden::ALL.iter().map(|k| k.id).collect()
}

/// Standard deviation of the force channel, N or N·m: what "one times the noise" means.
pub(crate) const NOISE: f64 = 0.062;
/// Samples per second of every recording.
const RATE: f64 = 1000.0;
