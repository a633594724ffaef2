#![doc = include_str!("../README.md")]
//!
//! ## Items
//!
//! * [`Rig`] advances one control period at a time: a command in, raw codes and time stamps out ([`Sensors`]), and the true
//!   state ([`Truth`]).
//! * [`Zoh`] is the exact solution of the mass-damper over a step [thesis, eq. 4.15].
//! * The block's friction is any [`friction::FrictionLaw`], a closure ([`friction::Custom`]), or a law with
//!   left-out effects on top ([`Layered`]).
//! * [`Hand`]s push the handle: [`HandForce`], [`HandImpedance`], or a closure of (t, x, v).
//! * [`ThesisExperiment`] is the identification experiment of [thesis, ch. 3.5] on the [`materials`] of [thesis, table 3-3].
//! * [`PlanarRig`] is a body on two axes on a surface with a law of [`friction::planar`].
//! * [`Calibration`] converts between codes and SI.
#![forbid(unsafe_code)]

mod calibration;
mod config;
mod contact;
mod encoder;
mod hand;
mod layered;
pub mod materials;
mod noise;
mod planar;
mod rig;
mod thesis;
mod truth;
mod wiring;
mod zoh;

pub use calibration::{Calibration, Channel};
pub use config::{Coupling, RigConfig, Sensor};
pub use hand::{Hand, HandForce, HandImpedance, NoHand, Target};
pub use layered::{Layered, LayeredState, MAX_CURVES, MAX_EFFECTS};
pub use planar::{Path, PlanarConfig, PlanarRig, PlanarSeries};
pub use rig::Rig;
pub use thesis::{Excitation, MeasurementNoise, Series, ThesisExperiment, thesis_recording};
pub use truth::{Sensors, Truth};
pub use wiring::{Bench, Wire, Wiring};
pub use zoh::Zoh;
