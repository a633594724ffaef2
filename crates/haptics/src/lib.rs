//! The control step of a 1-DOF friction display, `no_std`, `f32`, pure.
//!
//! ```text
//!  Inputs ──▶ estimator ──▶ machine ──▶ renderer | excitation ──▶ safety ──▶ Outputs
//!  counts,    M/T velocity   idle        friction    PD on a         clamp,
//!  ticks,                    rendering   on the      reference       faults
//!  codes                     exciting    handle
//!                            fault
//! ```
//!
//! [`step()`] is a function of [`Config`], [`State`], a [`Request`] and [`Inputs`]; time stamps are inputs. [`Control`]
//! holds configuration and state together and is the one place where a configuration is swapped.
//!
//! [`Settings`] are what people set, in SI: `validate` knows the physics of the [`Device`] ([`bounds`]) and `build`
//! turns them into the [`Config`] the loop runs.
//!
//! What this crate does *not* do: read a clock, touch hardware, allocate, log, or solve the identification it
//! accumulates inside the interrupt (see [`streaming_identify`]).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod bounds;
mod config;
mod control;
mod device;
pub mod estimator;
pub mod excitation;
mod fault;
mod filter;
mod io;
mod machine;
pub mod number;
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

pub use config::Config;
pub use control::Control;
pub use device::{Channel, Device, RATES};
pub use estimator::Estimator;
pub use excitation::Excitation;
pub use fault::{Denied, FaultKind};
pub use filter::{Biquad, BiquadState};
pub use io::{Inputs, Outputs};
pub use machine::{Fault, Mode, ModeId, Request};
pub use probe::Probe;
pub use settings::{LawKind, Parameter, RendererKind, SetError, Settings, Value};
pub use step::{State, step};
pub use streaming_identify::{Identified, Number, Procedure, Solver};
pub use verdict::{Accepted, Refused, Warning};
pub use wave::Wave;
