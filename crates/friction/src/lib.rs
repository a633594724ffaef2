#![doc = include_str!("../README.md")]
//!
//! ## Items by kind
//!
//! * Curves of velocity: [`Viscous`], [`Classic`], [`MajdSimaan`].
//! * Laws that hold a body at rest: [`Karnopp`], [`Coulomb`].
//! * Laws with presliding: [`Bristle`], [`Dahl`], [`HaywardArmstrong`], [`LuGre`], [`ElastoPlastic`], [`MaxwellSlip`],
//!   [`Armstrong`].
//! * Physics that a complete law leaves out, and what sensors and drives make of a record: [`effects`].
//! * Physics without a name: [`FreeForm`].
//! * Every law by its id, with its parameters: [`LAWS`], [`with_every_law`]; one chosen at run time: [`Law`], [`LawKind`],
//!   [`Surface`].
//! * Friction in the plane, isotropic or with a grain: [`planar`].
//! * Units: [`Dimension`], [`Geometry`], [`parameters`].
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(test)]
extern crate std;

#[macro_use]
mod about_law;

mod any;
mod armstrong;
mod bristle;
mod classic;
mod coulomb;
mod dahl;
mod decay;
mod dimension;
#[cfg(feature = "dual")]
mod dual;
pub mod effects;
mod elasto_plastic;
mod exponential;
mod free_form;
mod generalised_maxwell_slip;
mod hayward_armstrong;
mod karnopp;
mod law;
mod limits;
mod lugre;
mod majd_simaan;
pub mod parameters;
pub mod planar;
mod scalar;
mod sine;
mod surface;
mod viscous;

pub use about_law::{AboutLaw, DescribeLaw, LAWS, LawParameter};
pub use any::{BONDS, Law, LawKind, LawState};
pub use armstrong::{Armstrong, ArmstrongState};
pub use bristle::{Bristle, BristleState};
pub use classic::Classic;
pub use coulomb::{Coulomb, CoulombState};
pub use dahl::{Dahl, DahlState};
pub use decay::mean_decay;
pub use dimension::{Dimension, Geometry, Unit};
pub use elasto_plastic::{ElastoPlastic, ElastoPlasticState};
pub use free_form::{Coordinate, Factor, FreeForm, FreeFormState, Knots, MAX_KNOTS, MAX_VALUES};
pub use generalised_maxwell_slip::{MaxwellSlip, MaxwellSlipState};
pub use hayward_armstrong::{Adhesion, HaywardArmstrong, HaywardArmstrongState};
pub use karnopp::Karnopp;
pub use law::{Custom, FrictionLaw, Invalid, Motion, in_range};
pub use lugre::{LuGre, LuGreState};
pub use majd_simaan::MajdSimaan;
pub use scalar::Scalar;
pub use surface::{BOTH_DIRECTIONS, Surface, directions};
pub use viscous::Viscous;
