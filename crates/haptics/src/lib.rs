#![doc = include_str!("../README.md")]
//!
//! ## Items
//!
//! * [`step()`] is the control step, a function of [`Config`], [`State`], a [`Request`] and [`Inputs`]. [`Control`] holds
//!   configuration and state together and swaps configurations.
//! * [`Settings`] become a [`Config`] for a [`Device`]; [`bounds`] has the formulas.
//! * [`streaming_identify`] accumulates an identification in the interrupt and solves it outside.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod bounds;
pub mod compensation;
mod config;
mod control;
mod device;
mod device_settings;
pub mod drive;
pub mod estimator;
pub mod excitation;
mod fault;
mod filter;
pub mod generator;
mod homing;
mod io;
mod machine;
mod mode_id;
pub mod monitor;
pub mod number;
mod passivity;
pub mod planar;
mod presets;
mod probe;
pub mod renderer;
mod safety;
pub mod settings;
mod silence;
mod step;
pub mod streaming_identify;
mod verdict;
pub mod wave;

pub use compensation::Compensation;
pub use config::Config;
pub use control::Control;
pub use device::{Channel, Device, NOMINAL_SUPPLY, RATES, Sheet};
pub use device_settings::{DEVICE_SETTINGS, DeviceSetting, DeviceValue};
pub use estimator::Estimator;
pub use excitation::Excitation;
pub use fault::{Denied, FaultKind};
pub use filter::{Biquad, BiquadState};
pub use homing::{Homed, Homing};
pub use io::{Inputs, Outputs};
pub use machine::{Fault, Mode, Request};
pub use mode_id::ModeId;
pub use monitor::{Limit, Limits, Monitor};
pub use probe::{Probe, Ramp};
pub use settings::{LawKind, Parameter, RendererKind, SetError, Settings, Value};
pub use step::{State, step};
pub use streaming_identify::{Identified, Number, Procedure, Solver};
pub use verdict::{Accepted, Reason, Refused, Warning};
pub use wave::Wave;
