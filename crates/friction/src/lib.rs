//! Friction laws, `no_std`, written once and used four times: inside the renderer on the microcontroller
//! (`f32`), in the simulated rig (`f64`), as the model whose parameters are identified (dual numbers), and as
//! a hypothesis about what a simulation left out.
//!
//! Two kinds of law live here:
//! * [`FrictionLaw`]s, complete models of a sliding contact: [`Viscous`], [`Classic`], [`MajdSimaan`], which are curves
//!   of velocity; [`Karnopp`], [`Coulomb`], which hold; [`Bristle`], [`Dahl`], [`HaywardArmstrong`], [`LuGre`],
//!   [`ElastoPlastic`], [`MaxwellSlip`], [`Armstrong`], which give before they slide;
//! * [`effects`], the physics a complete model leaves out, each one file, linear in its gains.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod any;
mod armstrong;
mod bristle;
mod classic;
mod coulomb;
mod dahl;
mod decay;
#[cfg(feature = "dual")]
mod dual;
pub mod effects;
mod elasto_plastic;
mod exponential;
mod generalised_maxwell_slip;
mod hayward_armstrong;
mod karnopp;
mod law;
mod limits;
mod lugre;
mod majd_simaan;
mod scalar;
mod sine;
mod viscous;

pub use any::{Law, LawState};
pub use armstrong::{Armstrong, ArmstrongState};
pub use bristle::{Bristle, BristleState};
pub use classic::Classic;
pub use coulomb::{Coulomb, CoulombState};
pub use dahl::{Dahl, DahlState};
pub use decay::mean_decay;
pub use elasto_plastic::{ElastoPlastic, ElastoPlasticState};
pub use generalised_maxwell_slip::{MaxwellSlip, MaxwellSlipState};
pub use hayward_armstrong::{Adhesion, HaywardArmstrong, HaywardArmstrongState};
pub use karnopp::Karnopp;
pub use law::{Custom, FrictionLaw, Invalid, Motion, in_range};
pub use lugre::{LuGre, LuGreState};
pub use majd_simaan::MajdSimaan;
pub use scalar::Scalar;
pub use viscous::Viscous;
