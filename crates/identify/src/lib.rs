//! Friction identified from recordings.
//!
//! [`prepare`] derives [`Signals`] from a recording; [`identify_karnopp`] [thesis, eq. 3.5 to 3.9] or [`identify_dahl`]
//! [thesis, eq. 3.2, 3.3, 3.10] fits them. The result is an [`Identification`], and a [`Model`] predicts, simulates, and is a
//! preset of the device. [`planar`] does the same with two axes.
#![forbid(unsafe_code)]

mod dahl;
mod dahl_fit;
mod errors;
mod identification;
mod karnopp;
mod linear;
mod model;
mod model_curves;
mod model_read;
mod model_toml;
mod model_words;
mod moves;
pub mod planar;
mod predict;
mod preprocess;
mod ready;
mod static_level;
mod uncertain;
mod unfiltered;

pub use dahl::{DahlOptions, DahlStart, identify_dahl, identify_dahl_watched};
pub use errors::Errors;
pub use identification::{Estimate, Identification, NotIdentifiable, SCHEMA};
pub use karnopp::{KarnoppOptions, identify_karnopp};
pub use model::{Coupling, Model, Nuisances, preset_name};
pub use model_words::MODEL_SCHEMA;
pub use preprocess::{Preprocess, Signals, prepare, signals_of};
pub use uncertain::Predicted;
