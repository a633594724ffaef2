//! Models in the formats of simulators: MJCF (MuJoCo) and URDF.
//!
//! ```text
//! reduce   the joint that a format can hold, and a line for each thing that it cannot
//! mjcf     the joint as MJCF
//! urdf     the joint as URDF
//! ```
//!
//! A format holds a sum of few terms: friction of one level, one damping, in MJCF also a linear spring. A model is reduced to them
//! step by step. Every step says what it drops, and how much force that is on a recording.
#![forbid(unsafe_code)]

mod error;
mod mjcf;
mod reduce;
mod urdf;

pub use error::Error;
pub use reduce::{Dropped, Exported, Joint};

use identify::Model;
use signals::Recording;

/// Format of a simulator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// MJCF of MuJoCo: damping, friction loss, a linear spring.
    Mujoco,
    /// URDF: damping, friction, limits of a slide.
    Urdf,
}

/// A model in a format; `recording` shows how much force is lost, and gives a slide's limits to URDF.
///
/// # Errors
/// A model that is not valid or has no mass, a recording that the model cannot predict, a slide without limits for URDF.
pub fn export(model: &Model, format: Format, recording: Option<&Recording>) -> Result<Exported, Error> {
    let mut exported = reduce::reduce(model, format, recording)?;
    let name = name(&model.name);
    exported.text = match format {
        Format::Mujoco => mjcf::write(&name, &exported),
        Format::Urdf => urdf::write(&name, &exported, recording)?,
    };
    Ok(exported)
}

/// A name that every format takes.
fn name(name: &str) -> String {
    let clean: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' }).collect();
    if clean.is_empty() { "body".into() } else { clean }
}

/// What is dropped, as an XML comment.
fn comment(name: &str, exported: &Exported) -> String {
    let mut out = format!("<!-- {name}, written by tribos {}. Not held here:\n", env!("CARGO_PKG_VERSION"));
    for line in exported.lines() {
        // two hyphens would end the comment
        out += &format!("     {}\n", line.replace("--", "- -"));
    }
    out + "-->\n"
}
