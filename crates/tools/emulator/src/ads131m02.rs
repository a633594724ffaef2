//! A 24-bit converter ADS131M02 on the load cell, as its data sheet has it, with wires that can fail.
//!
//! It converts by its own clock and keeps the last two values: a reader that is slower than it gets the older one
//! [ads131m02, ch. 8.5.1.9.1]. Its sinc³ filter delays by one and a half conversions.

use crate::UNITS_PER_SECOND;
use crate::spi::Chip;
use crate::world::World;

/// Its clock, Hz: twice that of the modulator.
const CLOCK_HZ: u64 = 8_192_000;
/// Oversampling by the field OSR of its register CLOCK, without the turbo mode.
const OVERSAMPLING: [u64; 8] = [128, 256, 512, 1_024, 2_048, 4_096, 8_192, 16_384];
/// Registers after a reset: MODE, CLOCK, GAIN1 at 2, 3, 4.
const RESET: [u16; 16] = {
    let mut registers = [0; 16];
    registers[0] = 0x2200;
    registers[2] = 0x0510;
    registers[3] = 0x030e;
    registers
};
/// Gain for which the bridge is made: its full scale is that of the codes of [`World::load_at`].
const GAIN: u16 = 7;

/// What is wrong with the converter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ConverterFault {
    /// Nothing.
    #[default]
    None,
    /// Its plug is out: the pull-up of the line.
    Unplugged,
    /// This bit of every answer is flipped, 0 … 87.
    FlippedBit(u8),
    /// Its clock stands.
    NoClock,
}

#[derive(Debug)]
pub(crate) struct Ads131m02 {
    fault: ConverterFault,
    registers: [u16; 16],
    bytes: usize,
    received: [u8; 12],
    answer: [u8; 12],
    /// Answer to the last command.
    response: Option<u16>,
    /// Conversions that were read or lost.
    seen: u64,
    value: i32,
    /// Time of the force that the last answer shows.
    pub seen_at: Option<u64>,
    stopped_at: Option<u64>,
}

impl Ads131m02 {
    pub fn new() -> Self {
        Self {
            fault: ConverterFault::None,
            registers: RESET,
            bytes: 0,
            received: [0; 12],
            answer: [0; 12],
            response: None,
            seen: 0,
            value: 0,
            seen_at: None,
            stopped_at: None,
        }
    }

    /// Breaks or repairs it.
    pub fn set_fault(&mut self, fault: ConverterFault, now: u64) {
        self.fault = fault;
        self.stopped_at = (fault == ConverterFault::NoClock).then_some(now);
    }

    /// Cuts its supply for a moment: it has its settings no more.
    pub fn restart(&mut self) {
        (self.registers, self.response) = (RESET, None);
    }

    /// Time of a conversion, units.
    fn period(&self) -> u64 {
        OVERSAMPLING[usize::from(self.registers[3] >> 2 & 7)] * 2 * UNITS_PER_SECOND / CLOCK_HZ
    }

    /// Latches status and value as NSS falls.
    fn latch(&mut self, now: u64, world: &World) {
        let period = self.period();
        let last = self.stopped_at.unwrap_or(now).min(now) / period;
        let new = last.saturating_sub(self.seen);
        let on = self.registers[3] & 0x100 != 0;
        if new > 0 && on {
            // the older of the two that it keeps
            let index = if new > 1 { last - 1 } else { last };
            self.seen = index.max(self.seen + 1);
            let at = (index * period).saturating_sub(3 * period / 2);
            let scale = f64::from(1_u32 << (self.registers[4] & 7)) / f64::from(1_u32 << GAIN);
            let code = f64::from(world.load_at(at)) - 32_768.0;
            self.value = (code * scale * 256.0).clamp(-8_388_608.0, 8_388_607.0) as i32;
            self.seen_at = Some(at);
        }
        // WLENGTH and RESET are those of MODE
        let status = self.registers[2] & 0x0700 | u16::from(new > 0 && on);
        let first = self.response.take().unwrap_or(status);
        self.answer = [0; 12];
        self.answer[..2].copy_from_slice(&first.to_be_bytes());
        self.answer[3..6].copy_from_slice(&(self.value << 8).to_be_bytes()[..3]);
        let crc = crc16(&self.answer[..9]);
        self.answer[9..11].copy_from_slice(&crc.to_be_bytes());
        if let ConverterFault::FlippedBit(bit) = self.fault {
            self.answer[usize::from(bit / 8 % 11)] ^= 1 << (bit % 8);
        }
    }

    /// Obeys the command of a whole frame.
    fn obey(&mut self) {
        let word = |k: usize| u16::from_be_bytes([self.received[3 * k], self.received[3 * k + 1]]);
        let (command, data) = (word(0), word(1));
        let register = usize::from(command >> 7 & 0x3f);
        match command >> 13 {
            3 if command & 0x7f == 0 => {
                if let Some(content) = self.registers.get_mut(register) {
                    *content = data;
                }
                self.response = Some(0x4000 | command & 0x1fff);
            }
            5 if command & 0x7f == 0 => self.response = self.registers.get(register).copied(),
            _ => {}
        }
    }
}

impl Chip for Ads131m02 {
    const MODE: u32 = 1;
    const FASTEST: u64 = 25_000_000;

    fn select(&mut self, _: u64) {
        self.bytes = 0;
    }

    fn answer(&mut self, now: u64, world: &World) -> u8 {
        if self.bytes == 0 {
            self.latch(now, world);
        }
        match self.fault {
            ConverterFault::Unplugged => 0xff,
            _ => self.answer.get(self.bytes).copied().unwrap_or(0),
        }
    }

    fn take(&mut self, byte: u8, _: u64, _: &World) {
        if let Some(received) = self.received.get_mut(self.bytes) {
            *received = byte;
        }
        self.bytes += 1;
        if self.bytes == self.received.len() && self.fault != ConverterFault::Unplugged {
            self.obey();
        }
    }
}

/// CRC-16 CCITT from 0xffff, bit by bit.
fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xffff, |crc, byte| {
        (0..8).fold(
            crc ^ u16::from(*byte) << 8,
            |crc, _| {
                if crc & 0x8000 != 0 { crc << 1 ^ 0x1021 } else { crc << 1 }
            },
        )
    })
}
