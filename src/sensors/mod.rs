//! Sensors on a serial bus: drivers over `embedded-hal`, without registers. A board passes the bus.
//!
//! crates.io has no driver for either chip (2026-11; `as5048a` and `mt6816` read other ones), so they are written here.
//! A frame that cannot be trusted is an error, never a value.

mod absolute_encoder;
pub mod ads131m02;
mod index_pulse;
mod load_cell;
pub mod mt6835;

pub use absolute_encoder::{AbsoluteEncoder, COUNTS_PER_TURN, Count, angle_at};
pub use ads131m02::Ads131m02;
pub use index_pulse::IndexPulse;
pub use load_cell::LoadCell;
pub use mt6835::Mt6835;
