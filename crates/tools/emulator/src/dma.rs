//! DMA1 and its request multiplexer: single transfers between RAM and a register, circular or not, and their interrupts. A
//! transfer takes no time, and an error is a violation, not a flag.

use crate::image::RAM_BASE;
use rsemu::core::space::RamStore;
use std::sync::Arc;

/// Flags of all channels, four bits each, and where they are cleared.
const ISR: u32 = 0x00;
const IFCR: u32 = 0x04;
/// Those of channel 1: any, its end, its half. Bits 1 and 2 of its CR let the latter two interrupt.
const ISR_GIF1: u32 = 1 << 0;
const ISR_TCIF1: u32 = 1 << 1;
const ISR_HTIF1: u32 = 1 << 2;
/// Offsets in a channel, and their distance [rm0440, "DMA register map"].
const CHANNEL_0: u32 = 0x08;
const STRIDE: u32 = 0x14;
const CHANNELS: usize = 8;
/// Offset of the multiplexer from the controller.
pub(crate) const MUX: u32 = 0x800;

#[derive(Debug, Clone, Copy, Default)]
struct Channel {
    cr: u32,
    /// Transfers left, and after a restart.
    left: u32,
    reload: u32,
    par: u32,
    mar: u32,
    /// Transfers done since the start.
    done: u32,
    flags: u32,
}

impl Channel {
    fn is_on(&self) -> bool {
        self.cr & 1 != 0
    }

    /// log2 of the bytes of a unit in memory.
    fn size(&self) -> u32 {
        self.cr >> 10 & 3
    }
}

/// A transfer that a request asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Transfer {
    /// Write this to the register at this address.
    ToRegister { address: u32, value: u32 },
    /// Read the register at this address and pass it to [`Dma::received`].
    FromRegister { address: u32, channel: usize },
}

#[derive(Debug, Default)]
pub(crate) struct Dma {
    channels: [Channel; CHANNELS],
    mux: [u32; 16],
    /// The RAM of the chip; none in tests of single models.
    ram: Option<Arc<RamStore>>,
    pub violation: Option<String>,
}

impl Dma {
    /// After a reset, on the same memory.
    pub fn reset(&mut self) {
        *self = Self { ram: self.ram.take(), ..Self::default() };
    }

    /// Connects the RAM.
    pub fn attach(&mut self, ram: Arc<RamStore>) {
        self.ram = Some(ram);
    }

    /// Channel and register at an offset of the controller.
    fn place(offset: u32) -> Option<(usize, u32)> {
        let from = offset.checked_sub(CHANNEL_0)?;
        let channel = (from / STRIDE) as usize;
        (channel < CHANNELS).then_some((channel, from % STRIDE))
    }

    pub fn read(&self, offset: u32) -> u32 {
        if let Some(of_mux) = offset.checked_sub(MUX) {
            return self.mux.get(of_mux as usize / 4).copied().unwrap_or(0);
        }
        if offset == ISR {
            let flags = |c: &Channel| c.flags | if c.flags != 0 { ISR_GIF1 } else { 0 };
            return self.channels.iter().rev().fold(0, |isr, channel| isr << 4 | flags(channel));
        }
        let Some((channel, register)) = Self::place(offset) else { return 0 };
        let channel = &self.channels[channel];
        match register {
            0x00 => channel.cr,
            0x04 => channel.left,
            0x08 => channel.par,
            0x0c => channel.mar,
            _ => 0,
        }
    }

    pub fn write(&mut self, offset: u32, value: u32) {
        if let Some(of_mux) = offset.checked_sub(MUX) {
            if let Some(register) = self.mux.get_mut(of_mux as usize / 4) {
                *register = value;
            }
            return;
        }
        if offset == IFCR {
            for (k, channel) in self.channels.iter_mut().enumerate() {
                let clear = value >> (4 * k) & 0xf;
                channel.flags &= if clear & ISR_GIF1 != 0 { 0 } else { !clear };
            }
            return;
        }
        let Some((number, register)) = Self::place(offset) else { return };
        let channel = &mut self.channels[number];
        let on = channel.is_on();
        match register {
            0x00 => {
                channel.cr = value;
                if !on && channel.is_on() {
                    channel.done = 0;
                }
            }
            // only a channel that is off takes them [rm0440, "Channel configuration procedure"]
            0x04 | 0x08 | 0x0c if on => {
                self.violation = Some(format!("DMA1 channel {} set while it is on", number + 1));
            }
            0x04 => (channel.left, channel.reload) = (value & 0xffff, value & 0xffff),
            0x08 => channel.par = value,
            0x0c => channel.mar = value,
            _ => {}
        }
    }

    /// Whether a channel interrupts.
    pub fn interrupt(&self, number: usize) -> bool {
        let channel = &self.channels[number];
        channel.flags & channel.cr & (ISR_TCIF1 | ISR_HTIF1) != 0
    }

    /// Transfer that a channel makes on a request; none if no channel waits for it.
    pub fn request(&mut self, request: u32) -> Option<Transfer> {
        let mut waiting = (0..CHANNELS).filter(|k| {
            let channel = &self.channels[*k];
            self.mux[*k] & 0x7f == request && channel.is_on() && channel.left > 0
        });
        let number = waiting.next()?;
        if waiting.next().is_some() {
            self.violation = Some(format!("two channels of DMA1 wait for request {request}"));
        }
        let channel = self.channels[number];
        let address = channel.par;
        if channel.cr & 0x10 == 0 {
            return Some(Transfer::FromRegister { address, channel: number });
        }
        let mut bytes = [0; 4];
        let width = 1 << channel.size();
        if !self.memory(&channel, |ram, at| ram.read_at(at, &mut bytes[..width]).is_ok()) {
            self.violation = Some(format!("DMA1 channel {} reads outside the RAM", number + 1));
        }
        self.advance(number);
        Some(Transfer::ToRegister { address, value: u32::from_le_bytes(bytes) })
    }

    /// Stores what a channel read from its register.
    pub fn received(&mut self, number: usize, value: u32) {
        let channel = self.channels[number];
        let bytes = value.to_le_bytes();
        let width = 1 << channel.size();
        if !self.memory(&channel, |ram, at| ram.write_at(at, &bytes[..width]).is_ok()) {
            self.violation = Some(format!("DMA1 channel {} writes outside the RAM", number + 1));
        }
        self.advance(number);
    }

    fn memory(&self, channel: &Channel, access: impl FnOnce(&RamStore, u64) -> bool) -> bool {
        let step = if channel.cr & 0x80 != 0 { channel.done << channel.size() } else { 0 };
        let at = channel.mar.wrapping_add(step).checked_sub(RAM_BASE);
        at.zip(self.ram.as_ref()).is_some_and(|(at, ram)| access(ram, u64::from(at)))
    }

    fn advance(&mut self, number: usize) {
        let channel = &mut self.channels[number];
        channel.left -= 1;
        channel.done += 1;
        if channel.left == channel.reload / 2 {
            channel.flags |= ISR_HTIF1;
        }
        if channel.left == 0 {
            channel.flags |= ISR_TCIF1;
        }
        if channel.left == 0 && channel.cr & 0x20 != 0 {
            (channel.left, channel.done) = (channel.reload, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_moves_what_its_request_asks_for() {
        let ram = Arc::new(RamStore::new(64));
        ram.write_at(8, &[1, 2, 3]).expect("inside");
        let mut dma = Dma::default();
        dma.attach(Arc::clone(&ram));
        dma.write(MUX + 4, 13);
        dma.write(0x1c + 8, 0x4000_380c);
        dma.write(0x1c + 12, RAM_BASE + 8);
        dma.write(0x1c + 4, 3);
        assert_eq!(dma.request(13), None, "off");
        dma.write(0x1c, 1 | 0x10 | 0x80);
        assert_eq!(dma.request(12), None, "another request");
        let sent = [1, 2, 3].map(|value| Some(Transfer::ToRegister { address: 0x4000_380c, value }));
        assert_eq!([(); 3].map(|()| dma.request(13)), sent);
        assert_eq!((dma.request(13), dma.read(0x1c + 4)), (None, 0), "ended");
        assert!(dma.read(ISR) == 0x70 && !dma.interrupt(1), "ended, and nobody asked for the interrupt");
        dma.write(0x1c, 1 | 2 | 0x10 | 0x80);
        assert!(dma.interrupt(1));
        dma.write(IFCR, 0x20);
        assert!(dma.read(ISR) == 0x50 && !dma.interrupt(1));
        dma.write(IFCR, 0x10);
        assert_eq!(dma.read(ISR), 0);
        dma.write(0x1c + 4, 3);
        assert!(dma.violation.take().is_some(), "set while on");
        // the other way, round and round
        dma.write(MUX, 12);
        for (register, value) in [(12, RAM_BASE + 20), (4, 2), (0, 1 | 0x20 | 0x80)] {
            dma.write(8 + register, value);
        }
        for value in [7, 8, 9] {
            let Some(Transfer::FromRegister { channel, .. }) = dma.request(12) else { panic!("no transfer") };
            dma.received(channel, value);
        }
        let mut got = [0; 2];
        ram.read_at(20, &mut got).expect("inside");
        assert_eq!((got, dma.violation), ([9, 8], None));
    }
}
