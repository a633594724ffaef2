//! Recordings in and out, their audit, and friction identified from them.
//!
//! A [`Recording`] is read from CSV, JSON or MATLAB v5, [`audit`]ed, [`prepare`]d into [`Signals`] behind one stated
//! zero-phase filter, and fitted: [`identify_karnopp`] (thesis eq. 3.5 to 3.9) or [`identify_dahl`] (eq. 3.2, 3.3,
//! 3.10, σ included). The answer is an [`Identification`], and as a [`Model`] it predicts, simulates, and is a
//! preset of the device.
//!
//! Units are SI: s, m, m/s, m/s², N, kg; on a rotary axis rad, rad/s, rad/s², N·m, kg·m².
#![forbid(unsafe_code)]

mod audit;
mod bridge;
mod calibrate;
mod columns;
mod csv_io;
mod cutoff;
mod dahl;
mod dahl_fit;
pub mod dynamics;
mod error;
mod expression;
mod filter;
mod identification;
mod json_io;
mod karnopp;
mod linear;
mod mat_io;
mod model;
mod model_read;
mod model_toml;
mod moves;
mod noise;
mod predict;
mod preprocess;
mod ready;
mod recording;
mod sensor_effect;
mod smoother;
mod sources;
mod static_level;
mod stretches;

pub use audit::{Audit, FaultKind, RecordingFault, audit, without_outliers};
pub use bridge::{Bridged, bridged};
pub use calibrate::{Calibration, calibrate_accelerometer};
pub use dahl::{DahlOptions, DahlStart, identify_dahl};
pub use error::{Error, Place};
pub use expression::Map;
pub use filter::{
    Design, Filter, Kind, Section, central_difference, decimate, four_point_difference, zero_phase,
};
pub use identification::{Estimate, Identification, NotIdentifiable, SCHEMA};
pub use karnopp::{Errors, KarnoppOptions, identify_karnopp};
pub use model::{Coupling, Model, Nuisances};
pub use model_toml::MODEL_SCHEMA;
pub use noise::noise_variance;
pub use preprocess::{Preprocess, Signals, prepare};
pub use recording::{Geometry, ReadOptions, Recording};
pub use sensor_effect::SensorEffect;
