//! An absolute encoder MT6835 on the handle, as its data sheet has it, with wires that can fail.

use crate::UNITS_PER_SECOND;
use crate::random::Random;
use crate::spi::Chip;
use crate::world::World;

/// Travel of the handle in a turn, m.
const TURN_M: f64 = 42.1e-3;
/// Steps in a turn.
const STEPS: f64 = (1_u32 << 21) as f64;
/// Share of a turn at the middle of the stroke: the end of the turn is within the stroke.
const MOUNTED: f64 = 0.85;
/// Noise, steps rms: 0.35 µm. *Assumed*; a chip's depends on its filter.
const NOISE: f64 = 17.0;
/// From the motion to the angle, units: 2 µs. *Assumed*.
const PROPAGATION: u64 = 2 * UNITS_PER_SECOND / 1_000_000;
/// The command of an angle.
const COMMAND: [u8; 2] = [0xa0, 0x03];

/// What is wrong with the encoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EncoderFault {
    /// Nothing.
    #[default]
    None,
    /// Its plug is out: the pull-up of the line.
    Unplugged,
    /// Its output is shorted to ground.
    Grounded,
    /// This bit of every answer is flipped, 0 … 31.
    FlippedBit(u8),
    /// The magnet fell off.
    MagnetLost,
    /// Its supply is too low.
    LowSupply,
    /// The magnet turns on the shaft: the angle stays.
    Slips,
}

#[derive(Debug)]
pub(crate) struct Mt6835 {
    pub fault: EncoderFault,
    noise: Random,
    /// Bytes since NSS fell.
    bytes: usize,
    command: [u8; 2],
    answer: [u8; 4],
    /// Angle while the magnet slips.
    kept: u32,
    /// Time of the motion that the last answer shows.
    pub seen_at: Option<u64>,
}

impl Mt6835 {
    pub fn new() -> Self {
        Self {
            fault: EncoderFault::None,
            noise: Random(6_835),
            bytes: 0,
            command: [0; 2],
            answer: [0; 4],
            kept: 0,
            seen_at: None,
        }
    }

    /// Latches the angle at the end of the command.
    fn latch(&mut self, now: u64, world: &World) {
        let at = now.saturating_sub(PROPAGATION);
        // twelve uniform numbers are a normal one
        let noise = NOISE * ((0..12).map(|_| self.noise.share()).sum::<f64>() - 6.0);
        let turns = world.position_at(at) / TURN_M + MOUNTED;
        let angle = (turns.rem_euclid(1.0) * STEPS + noise).round() as i64 as u32 & 0x1f_ffff;
        if self.fault != EncoderFault::Slips {
            self.kept = angle;
        }
        let status = match self.fault {
            EncoderFault::MagnetLost => 2,
            EncoderFault::LowSupply => 4,
            _ => 0,
        };
        let [_, high, middle, low] = (self.kept << 3 | status).to_be_bytes();
        self.answer = [high, middle, low, crc8(&[high, middle, low])];
        if let EncoderFault::FlippedBit(bit) = self.fault {
            self.answer[usize::from(bit / 8 % 4)] ^= 1 << (bit % 8);
        }
        self.seen_at = Some(at);
    }
}

impl Chip for Mt6835 {
    const MODE: u32 = 3;
    const FASTEST: u64 = 16_000_000;

    fn select(&mut self, _: u64) {
        self.bytes = 0;
    }

    fn answer(&mut self, now: u64, world: &World) -> u8 {
        if self.bytes == 2 {
            self.latch(now, world);
        }
        let known = self.command == COMMAND;
        let answer = self.bytes.checked_sub(2).and_then(|k| self.answer.get(k)).filter(|_| known);
        match self.fault {
            EncoderFault::Unplugged => 0xff,
            EncoderFault::Grounded => 0,
            _ => answer.copied().unwrap_or(0),
        }
    }

    fn take(&mut self, byte: u8, _: u64, _: &World) {
        if let Some(command) = self.command.get_mut(self.bytes) {
            *command = byte;
        }
        self.bytes += 1;
    }
}

/// CRC-8 with x⁸ + x² + x + 1, bit by bit.
fn crc8(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |crc, byte| {
        (0..8).fold(crc ^ byte, |crc, _| if crc & 0x80 != 0 { crc << 1 ^ 0x07 } else { crc << 1 })
    })
}
