//! The simulated rig of the thesis: device, load cell, block, sensors with their noise, and the human hand.
//!
//! * [`Rig`] advances one control period at a time: a command in, raw codes and time stamps out
//!   ([`Sensors`]), and beside them what really happened ([`Truth`]).
//! * The device is m·ẍ + b·ẋ = F, solved exactly over each of at least 10 integration steps a period
//!   ([`Zoh`], eq. 4.15). Friction is a stopping force: a zero crossing is an event, the body comes to rest
//!   there and leaves only under a load that friction cannot hold.
//! * The block's friction is any [`friction::FrictionLaw`], a closure ([`friction::Custom`]), or a law with
//!   left-out effects on top ([`Layered`]).
//! * [`Hand`]s push the handle: [`HandForce`], [`HandImpedance`], or a closure of (t, x, v).
//! * [`ThesisExperiment`] is the identification experiment of ch. 3.5 on the [`materials`] of table 3-3.
//! * [`Calibration`] turns codes into SI and back, for the rig and for whoever reads it.
//!
//! Positive is forward; a friction force is positive against forward motion.
#![forbid(unsafe_code)]

mod calibration;
mod config;
mod contact;
mod encoder;
mod hand;
mod layered;
pub mod materials;
mod noise;
mod rig;
mod thesis;
mod truth;
mod wiring;
mod zoh;

pub use calibration::{Calibration, Channel};
pub use config::{Coupling, RigConfig, Sensor};
pub use hand::{Hand, HandForce, HandImpedance, NoHand, Target};
pub use layered::{Layered, LayeredState, MAX_EFFECTS};
pub use rig::Rig;
pub use thesis::{Excitation, MeasurementNoise, Series, ThesisExperiment, thesis_recording};
pub use truth::{Sensors, Truth};
pub use wiring::{Bench, Wire, Wiring};
pub use zoh::Zoh;
