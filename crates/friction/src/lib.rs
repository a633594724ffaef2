//! Friction laws, `no_std`, written once and used four times: inside the renderer on the microcontroller
//! (`f32`), in the simulated rig (`f64`), as the model whose parameters are identified (dual numbers), and as
//! a hypothesis about what a simulation left out.
//!
//! Two kinds of law live here:
//! * [`FrictionLaw`]s, complete models of a sliding contact: [`Karnopp`], [`Dahl`], [`Coulomb`], [`LuGre`];
//! * [`effects`], the physics a complete model leaves out, each one file, linear in its gains.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod law;
mod scalar;

pub use law::{Custom, FrictionLaw, Invalid, Motion, in_range};
pub use scalar::Scalar;
