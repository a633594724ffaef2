//! SPI as a master of 8 bits: rate, mode, FIFOs, NSS by hardware, DMA requests. Bytes take time.

use crate::units_per_cycle;
use crate::world::World;
use std::collections::VecDeque;
use std::fmt::Debug;

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SR: u32 = 0x08;
const DR: u32 = 0x0c;
const CRCPR: u32 = 0x10;
const I2SPR: u32 = 0x20;
const CR1_MSTR: u32 = 1 << 2;
const CR1_SPE: u32 = 1 << 6;
const CR1_SSM: u32 = 1 << 9;
const CR2_RXDMAEN: u32 = 1 << 0;
const CR2_TXDMAEN: u32 = 1 << 1;
const CR2_SSOE: u32 = 1 << 2;
const CR2_FRXTH: u32 = 1 << 12;
const SR_RXNE: u32 = 1 << 0;
const SR_TXE: u32 = 1 << 1;
const SR_OVR: u32 = 1 << 6;
const SR_BSY: u32 = 1 << 7;
/// Bytes in each FIFO.
const DEPTH: usize = 4;
/// Level of the line without a chip: its pull-up.
const OPEN: u8 = 0xff;

/// A chip on the bus.
pub(crate) trait Chip: Debug + Send {
    /// Clock polarity and phase, as the two lowest bits of SPI_CR1.
    const MODE: u32;
    /// Fastest clock, Hz.
    const FASTEST: u64;

    /// NSS falls.
    fn select(&mut self, now: u64);

    /// Answers the byte that begins now, of which the chip has not seen a bit.
    fn answer(&mut self, now: u64, world: &World) -> u8;

    /// The byte has ended.
    fn take(&mut self, byte: u8, now: u64, world: &World);
}

#[derive(Debug)]
pub(crate) struct Spi<C> {
    regs: [u32; 16],
    sending: VecDeque<u8>,
    received: VecDeque<u8>,
    overrun: bool,
    /// End of the byte on the wire, its bits, and those of the answer.
    shifting: Option<(u64, u8, u8)>,
    clock_hz: u64,
    /// Whether the four pins are those of the peripheral.
    pub wired: bool,
    pub chip: C,
    pub violation: Option<String>,
}

impl<C: Chip> Spi<C> {
    pub fn new(chip: C) -> Self {
        let mut spi = Self {
            regs: [0; 16],
            sending: VecDeque::new(),
            received: VecDeque::new(),
            overrun: false,
            shifting: None,
            clock_hz: 0,
            wired: false,
            chip,
            violation: None,
        };
        spi.reset();
        spi
    }

    /// Resets the registers. The chip has its own supply.
    pub fn reset(&mut self) {
        self.regs = [0; 16];
        self.set(CR2, 0x700);
        self.set(CRCPR, 7);
        self.set(I2SPR, 2);
        (self.overrun, self.shifting) = (false, None);
        self.sending.clear();
        self.received.clear();
    }

    fn reg(&self, offset: u32) -> u32 {
        self.regs.get(offset as usize / 4).copied().unwrap_or(0)
    }

    fn set(&mut self, offset: u32, value: u32) {
        if let Some(register) = self.regs.get_mut(offset as usize / 4) {
            *register = value;
        }
    }

    fn on(&self) -> bool {
        self.reg(CR1) & CR1_SPE != 0
    }

    pub fn read(&mut self, offset: u32) -> u32 {
        match offset {
            SR => {
                let mut sr = if self.sending.len() <= DEPTH / 2 { SR_TXE } else { 0 };
                sr |= if self.received.is_empty() { 0 } else { SR_RXNE };
                sr |= if self.overrun { SR_OVR } else { 0 };
                sr |= if self.shifting.is_some() { SR_BSY } else { 0 };
                let level = |bytes: usize| bytes.min(3) as u32;
                sr | level(self.received.len()) << 9 | level(self.sending.len()) << 11
            }
            DR => self.received.pop_front().map_or(0, u32::from),
            _ => self.reg(offset),
        }
    }

    /// A store; of one byte, if it is to the data register. `hz` is the clock of the bus of the registers.
    pub fn write(&mut self, offset: u32, value: u32, now: u64, hz: u64, world: &World) {
        self.clock_hz = hz;
        match offset {
            CR1 => {
                let was = self.on();
                self.set(CR1, value);
                if was && !self.on() && self.shifting.take().is_some() {
                    self.violation = Some("SPI disabled during a byte".into());
                }
                if !was && self.on() {
                    self.begin(now);
                }
            }
            SR => {}
            DR if self.sending.len() < DEPTH => self.sending.push_back(value as u8),
            DR => self.violation = Some("SPI data written into a full FIFO".into()),
            _ => self.set(offset, value),
        }
        self.shift(now, world);
    }

    /// SPE rises, and NSS falls with it.
    fn begin(&mut self, now: u64) {
        if !self.is_selected() {
            return;
        }
        let (cr1, cr2) = (self.reg(CR1), self.reg(CR2));
        let hz = self.clock_hz / self.divider();
        if hz > C::FASTEST {
            self.violation = Some(format!("SPI at {hz} Hz, more than {} Hz", C::FASTEST));
        }
        if cr1 & 3 != C::MODE || cr2 >> 8 & 0xf != 7 || cr2 & CR2_FRXTH == 0 {
            self.violation = Some(format!("SPI mode {}, CR2 {cr2:#x}: not those of the chip", cr1 & 3));
        }
        self.chip.select(now);
    }

    /// Whether NSS is low: by hardware, from SPE to SPE.
    fn is_selected(&self) -> bool {
        let (cr1, cr2) = (self.reg(CR1), self.reg(CR2));
        let by_hardware = cr1 & CR1_SSM == 0 && cr2 & CR2_SSOE != 0;
        self.wired && self.on() && cr1 & CR1_MSTR != 0 && by_hardware
    }

    fn divider(&self) -> u64 {
        2 << (self.reg(CR1) >> 3 & 7)
    }

    fn shift(&mut self, now: u64, world: &World) {
        if !self.on() || self.reg(CR1) & CR1_MSTR == 0 || self.shifting.is_some() {
            return;
        }
        let Some(byte) = self.sending.pop_front() else { return };
        let answer = if self.is_selected() { self.chip.answer(now, world) } else { OPEN };
        let length = 8 * self.divider() * units_per_cycle(self.clock_hz);
        self.shifting = Some((now + length, byte, answer));
    }

    /// Ends bytes that are due.
    pub fn advance(&mut self, now: u64, world: &World) {
        while let Some((end, byte, answer)) = self.shifting
            && now >= end
        {
            self.shifting = None;
            if self.is_selected() {
                self.chip.take(byte, end, world);
            }
            if self.received.len() < DEPTH {
                self.received.push_back(answer);
            } else {
                self.overrun = true;
            }
            self.shift(end, world);
        }
    }

    pub fn next_event(&self) -> u64 {
        self.shifting.map_or(u64::MAX, |(end, ..)| end)
    }

    /// Whether a byte waits for the DMA.
    pub fn wants_to_receive(&self) -> bool {
        self.reg(CR2) & CR2_RXDMAEN != 0 && !self.received.is_empty()
    }

    /// Whether there is room for a byte of the DMA.
    pub fn wants_to_send(&self) -> bool {
        self.reg(CR2) & CR2_TXDMAEN != 0 && self.sending.len() <= DEPTH / 2
    }
}
