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

mod any;
mod coulomb;
mod dahl;
#[cfg(feature = "dual")]
mod dual;
pub mod effects;
mod karnopp;
mod law;
mod limits;
mod lugre;
mod scalar;
mod sine;

pub use any::{Law, LawState};
pub use coulomb::{Coulomb, CoulombState};
pub use dahl::{Dahl, DahlState};
pub use karnopp::Karnopp;
pub use law::{Custom, FrictionLaw, Invalid, Motion, in_range};
pub use lugre::{LuGre, LuGreState};
pub use scalar::Scalar;
