//! Models in the formats of simulators: MJCF (MuJoCo) and URDF.
//!
//! ```text
//! reduce   the joint that a format can hold, and a line for each thing that it cannot
//! mjcf     the joint as MJCF
//! urdf     the joint as URDF
//! xml      names and comments of both
//! ```
//!
//! A format holds a sum of few terms: friction of one level, one damping, in MJCF also a linear spring. A model is reduced to them
//! step by step. Every step says what it drops, and how much force that is on a recording.
#![forbid(unsafe_code)]

mod error;
mod format;
mod mjcf;
mod reduce;
mod urdf;
mod xml;

pub use error::Error;
pub use format::Format;
pub use reduce::{Dropped, Exported, Joint};

use identify::Model;
use signals::Recording;

/// A model in a format; `recording` shows how much force is lost, and gives a slide's limits to URDF.
///
/// # Errors
/// A model that is not valid or has no mass, a recording that the model cannot predict, a slide without limits for URDF.
pub fn export(model: &Model, format: Format, recording: Option<&Recording>) -> Result<Exported, Error> {
    let mut exported = reduce::reduce(model, format, recording)?;
    let name = xml::name(&model.name);
    exported.text = match format {
        Format::Mujoco => mjcf::write(&name, &exported),
        Format::Urdf => urdf::write(&name, &exported, recording)?,
    };
    Ok(exported)
}
