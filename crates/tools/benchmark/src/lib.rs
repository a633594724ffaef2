//! Public benchmarks of system identification by their official protocols: [`silverbox`] and [`emps`].
//!
//! A benchmark is answered by *free run*: the first samples of a test set the state, then the model is driven by the
//! recorded force alone, and the figure is the root mean square error of the position. The model is named physics of
//! [`friction`], at most twelve parameters, fitted by equation error first and then by simulation error:
//!
//! * [`Place`] says where a parameter sits in a model, [`Plant`] is the model in any scalar;
//! * [`Drive`] is the recorded force between its samples;
//! * [`free_run`] integrates a plant under a drive, and stops at reversals;
//! * [`fit`] minimises the error of free runs over windows of a recording, with exact derivatives;
//! * [`rivals`] are the published figures, each with its source.
//!
//! The binary `cost` measures time and memory of a diagnosis.
#![forbid(unsafe_code)]

mod answer;
mod data;
mod drive;
pub mod emps;
mod equation;
mod error;
mod fit;
mod free_run;
mod place;
mod plant;
pub mod rivals;
mod settle;
pub mod silverbox;
mod structure;

pub use answer::{Answer, Compared, Figure, Force, Parameter, SCHEMA, Test};
pub use data::Record;
pub use drive::{Between, Drive};
pub use error::Error;
pub use fit::{Fitted, fit};
pub use free_run::{State, free_run};
pub use place::{Place, Way};
pub use plant::Plant;
pub use settle::settled;
pub use structure::{Found, Gain, Protocol, Stage, Structure, Term, gains, identified};
