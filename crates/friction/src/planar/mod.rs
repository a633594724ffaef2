//! Friction in the plane: deflection, velocity and force are vectors; the level is a disc, or an ellipse along a grain.
//!
//! One law, one file, and the shape of the laws on a line: `law.step(&mut state, &motion)`, configuration apart from
//! state, any [`Scalar`](crate::Scalar).
//!
//! | law | state | holds at rest |
//! | --- | --- | --- |
//! | [`Karnopp`] | | yes, in a disc of velocities |
//! | [`Coulomb`] | sticking or sliding | yes, exactly |
//! | [`Dahl`] | deflection | yes, drifts |
//! | [`LuGre`] | deflection | yes, drifts |
//! | [`ElastoPlastic`] | deflection | yes |
//!
//! What holds for each of them: along x or y, or along the grain where that is an axis, the force is that of the law on a
//! line to the last bit; without a grain, a turned motion has the turned force; the break-away level is the disc, or the
//! ellipse of [`Grain`]; no energy is gained over a closed path (LuGre and elasto-plastic where
//! [`crate::LuGre::is_passive`] holds).
//!
//! There is one level for all directions that differ by half a turn: a surface with a nap, rougher one way than the other,
//! is not described.

mod any;
mod coulomb;
mod dahl;
mod effect;
mod elasto_plastic;
mod grain;
mod karnopp;
mod law;
mod lugre;
mod vector;

pub use crate::coulomb::CoulombState;
pub use any::{Law, LawState};
pub use coulomb::Coulomb;
pub use dahl::{Dahl, DahlState};
pub use effect::{InPlane, bent};
pub use elasto_plastic::{ElastoPlastic, ElastoPlasticState};
pub use grain::Grain;
pub use karnopp::Karnopp;
pub use law::{FrictionLaw, Motion};
pub use lugre::{LuGre, LuGreState};
pub use vector::Vector;
