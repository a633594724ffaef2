//! Binary frames: encoding and decoding.
//!
//! ```text
//! payload   0x00 │ format id │ postcard(seq u32, body) │ CRC-16/IBM-3740, low byte first
//! wire      COBS(payload) 0x00          the leading zero makes the first wire byte 0x01
//! ```
//!
//! Raw codes go on the wire. The host converts them to SI with the calibration in the header.

use crc::{CRC_16_IBM_3740, Crc};
use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);
/// Longest payload, bytes.
const MAX_PAYLOAD: usize = 120;
/// Longest frame on the wire with its end, bytes.
pub const MAX_WIRE: usize = MAX_PAYLOAD + 3;

/// SI = (code − `offset_code`) · `unit_per_code`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Code that stands for zero.
    pub offset_code: f32,
    /// SI units per code.
    pub unit_per_code: f32,
}

/// First frame of a stream: everything needed to convert samples to SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Rate of the timer of all time stamps, Hz.
    pub tick_hz: u32,
    /// Control period, ticks.
    pub period_ticks: u32,
    /// Handle travel of one count, m.
    pub metre_per_count: f32,
    /// Load cell, N.
    pub load: Channel,
    /// Accelerometer, m/s².
    pub accel: Channel,
    /// Control periods per sample.
    pub decimation: u32,
    /// Active preset.
    pub preset: String<24>,
    /// Encoder count at position 0. A stream has a new header when it changes.
    pub origin_count: i32,
    /// Mechanics and limits of the device.
    pub mechanics: Mechanics,
}

/// What is not in the codes: whether lengths are angles, and what the device bears.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mechanics {
    /// Whether m is rad, N is N·m and kg is kg·m².
    pub rotary: bool,
    /// Distance between the stops, m.
    pub stroke: f32,
    /// Inertia of the handle, kg.
    pub mass: f32,
    /// Its damping, N·s/m.
    pub damping: f32,
    /// Largest force, N.
    pub force_max: f32,
    /// Largest speed, m/s.
    pub overspeed: f32,
}

/// One control period.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Number of the control step. Wraps.
    pub step: u32,
    /// Time of the sample, ticks. Wraps.
    pub sample_ticks: u32,
    /// Encoder count. Wraps.
    pub count: i32,
    /// Time since the last encoder edge, ticks: the open pulse interval.
    pub edge_age: u32,
    /// Load cell.
    pub load_code: u16,
    /// Accelerometer.
    pub accel_code: u16,
    /// Commanded force, N.
    pub force: f32,
    /// Reference of the excitation, m.
    pub reference: f32,
    /// [`haptics::ModeId`].
    pub mode: u8,
    /// [`haptics::FaultKind`], 0 for none.
    pub fault: u8,
    /// Whether position 0 is the middle of the stroke.
    pub referenced: bool,
    /// Number of samples lost since the stream began, because the line was full.
    pub dropped: u32,
}

impl Sample {
    /// Timer at the last encoder edge, ticks.
    #[must_use]
    pub fn edge_ticks(&self) -> u32 {
        self.sample_ticks.wrapping_sub(self.edge_age)
    }
}

/// Contents of a frame.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)] // no heap; one at a time
pub enum Frame {
    /// Format 5.
    Header(Header),
    /// Format 4.
    Sample(Sample),
}

impl Frame {
    /// Format id on the wire.
    #[must_use]
    pub fn format(&self) -> u8 {
        match self {
            Self::Header(_) => 5,
            Self::Sample(_) => 4,
        }
    }
}

/// Encodes a frame for the wire, terminator included.
///
/// `None` if the frame were longer than [`MAX_WIRE`]; a test shows that no frame is.
#[must_use]
pub fn encode(seq: u32, frame: &Frame) -> Option<Vec<u8, MAX_WIRE>> {
    let mut payload = [0; MAX_PAYLOAD];
    let (head, body) = payload.split_at_mut(2);
    head.copy_from_slice(&[0, frame.format()]);
    let used = match frame {
        Frame::Header(header) => postcard::to_slice(&(seq, header), body),
        Frame::Sample(sample) => postcard::to_slice(&(seq, sample), body),
    }
    .ok()?
    .len();
    let end = 2 + used;
    let sum = CRC.checksum(payload.get(..end)?).to_le_bytes();
    payload.get_mut(end..end + 2)?.copy_from_slice(&sum);
    let mut wire = Vec::new();
    wire.resize_default(MAX_WIRE).ok()?;
    let length = cobs::try_encode(payload.get(..end + 2)?, &mut wire).ok()?;
    wire.truncate(length);
    wire.push(0).ok()?;
    Some(wire)
}

/// Decodes a payload without its COBS encoding into sequence number and frame. `None` if it is not intact.
#[must_use]
pub fn decode_payload(payload: &[u8]) -> Option<(u32, Frame)> {
    let (body, sum) = payload.split_last_chunk::<2>()?;
    if CRC.checksum(body) != u16::from_le_bytes(*sum) {
        return None;
    }
    let [0, format, rest @ ..] = body else { return None };
    // no bytes may remain: a longer body is another format
    // formats 1 and 2 are of firmware that knew no origin, 3 of one without settings of the device
    match format {
        5 => match postcard::take_from_bytes::<(u32, Header)>(rest).ok()? {
            ((seq, header), []) => Some((seq, Frame::Header(header))),
            _ => None,
        },
        4 => match postcard::take_from_bytes::<(u32, Sample)>(rest).ok()? {
            ((seq, sample), []) => Some((seq, Frame::Sample(sample))),
            _ => None,
        },
        _ => None,
    }
}
