//! Models in the formats of simulators: MJCF (MuJoCo), URDF, Modelica, and the JSON of BAM.
//!
//! ```text
//! reduce   the joint that a format can hold, and a line for each thing that it cannot
//! part     what a format holds of an effect
//! mjcf     the joint as MJCF
//! urdf     the joint as URDF
//! xml      names and comments of both
//! modelica the joint of components of the Modelica Standard Library
//! bam      the joint as parameters of BAM
//! ```
//!
//! A format holds a sum of few terms: friction of one level, one damping, in MJCF also a linear spring, bristles and waves over
//! the position, in Modelica also tables over the speed and over the position, in BAM also friction that falls with the speed.
//! A model is reduced to them step by step. Every step says what it drops, and how much force that is on a recording.
#![forbid(unsafe_code)]

mod bam;
mod error;
mod format;
mod mjcf;
mod modelica;
mod part;
mod reduce;
mod urdf;
mod xml;

pub use error::Error;
pub use format::Format;
pub use part::{Falling, Wave};
pub use reduce::{Bristle, Dropped, Exported, Joint};

use identify::Model;
use signals::{Geometry, Recording};

/// A model in a format; `recording` shows how much force is lost, and gives a slide's limits to URDF.
///
/// # Errors
/// A model that is not valid or has no mass, a recording that the model cannot predict, a slide without limits for URDF,
/// a slide for BAM.
pub fn export(model: &Model, format: Format, recording: Option<&Recording>) -> Result<Exported, Error> {
    if format == Format::Bam && model.geometry == Geometry::Linear {
        return Err(Error::NotAnAxis);
    }
    let mut exported = reduce::reduce(model, format, recording)?;
    let name = xml::name(&model.name);
    exported.text = match format {
        Format::Mujoco => mjcf::write(&name, &exported),
        Format::Urdf => urdf::write(&name, &exported, recording)?,
        Format::Modelica => modelica::write(&name, &exported, recording),
        Format::Bam => bam::write(&name, &exported),
    };
    Ok(exported)
}
