//! What device and host both speak over one serial line, `no_std`.
//!
//! * **Down** (to the device) goes text, one [`Command`] a line: [`LineEditor`] makes lines of bytes.
//! * **Up** comes text, one answer a command (`ok …` or `err CODE: why`, [`reply`]), and between the lines binary
//!   [`Frame`]s while a stream is on. A frame always begins with the byte 0x01 and ends with 0x00, text has neither:
//!   [`Decoder`] takes the two apart, whatever was lost or mangled on the way.
//!
//! Lines that begin with `!` are news nobody asked for: a fault, the end of a motion, the result of an identification.
//!
//! [`PresetStore`] keeps the sets of parameters a device knows by name.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod command;
mod decoder;
mod frame;
mod help;
mod line;
mod preset;
pub mod reply;

pub use command::{BadCommand, Calibrate, Command, PresetCommand, Sensor};
pub use decoder::{Corrupt, Decoder, Item};
pub use frame::{Channel, Frame, Header, MAX_WIRE, Sample, decode_payload, encode};
pub use help::{HELP, HelpLine};
pub use line::{BadLine, LineEditor, MAX_LINE};
pub use preset::{Change, DEFAULT_KEY, IDENTIFIED, MAX_ITEM, MAX_SAVED, Name, PresetError, PresetStore};
