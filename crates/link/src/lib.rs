#![doc = include_str!("../README.md")]
//!
//! ## Items by direction
//!
//! * To the device: [`LineEditor`] assembles lines, [`Command`] parses them, [`HELP`] describes them; [`OffDetector`] finds `off`
//!   before all that.
//! * From the device: [`encode`] and [`Decoder`] for [`Frame`]s between the lines; [`reply`] for the form of an answer.
//! * On the device: [`PresetStore`] keeps named sets of parameters.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod command;
mod decoder;
mod frame;
mod help;
mod line;
mod off;
mod preset;
pub mod reply;

pub use command::{BadCommand, Calibrate, Command, DeviceCommand, PresetCommand, Sensor, Watch};
pub use decoder::{Corrupt, Decoder, Item};
pub use frame::{Channel, Frame, Header, MAX_WIRE, Mechanics, Sample, decode_payload, encode};
pub use help::{HELP, HelpLine};
pub use line::{BadLine, LineEditor, MAX_LINE};
pub use off::OffDetector;
pub use preset::{
    CALIBRATION_KEY, Change, DEFAULT_KEY, IDENTIFIED, MAX_ITEM, MAX_SAVED, Name, ORIGIN_KEY, PresetError,
    PresetStore,
};
