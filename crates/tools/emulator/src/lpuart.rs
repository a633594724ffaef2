//! LPUART1 and the terminal at the other end: bytes take time, frames need the right rate.

use crate::units_per_cycle;
use std::collections::VecDeque;

const CR1: u32 = 0x00;
const CR3: u32 = 0x08;
const BRR: u32 = 0x0c;
const ISR: u32 = 0x1c;
const ICR: u32 = 0x20;
const RDR: u32 = 0x24;
pub(crate) const TDR: u32 = 0x28;
/// CR3: the DMA is asked for bytes to send.
const CR3_DMAT: u32 = 1 << 7;

/// Rate of the terminal.
const TERMINAL_BAUD: f64 = 921_600.0;
const ISR_IDLE: u32 = 1 << 4;
const ISR_ORE: u32 = 1 << 3;
const ISR_FE: u32 = 1 << 1;
const ISR_TC: u32 = 1 << 6;
const ISR_TEACK: u32 = 1 << 21;
const ISR_REACK: u32 = 1 << 22;
const ISR_TXFE: u32 = 1 << 23;

#[derive(Debug, Default)]
pub(crate) struct Lpuart {
    regs: [u32; 16],
    flags: u32,
    /// Bytes typed at the terminal that are not yet on the wire.
    typed: VecDeque<u8>,
    /// Arrival time of the byte on the wire, and time of the idle line after the last byte.
    arrival: Option<u64>,
    idle_at: Option<u64>,
    received: VecDeque<u8>,
    sending: Option<(u64, u8)>,
    queued: VecDeque<u8>,
    /// Bytes shown by the terminal.
    pub shown: VecDeque<u8>,
    /// Number of bytes not read in time.
    pub overruns: u64,
    kernel_hz: u64,
}

impl Lpuart {
    pub fn new() -> Self {
        Self { flags: ISR_TC, ..Self::default() }
    }

    fn reg(&self, offset: u32) -> u32 {
        self.regs.get(offset as usize / 4).copied().unwrap_or(0)
    }

    fn depth(&self) -> usize {
        if self.reg(CR1) >> 29 & 1 != 0 { 8 } else { 1 }
    }

    fn on(&self, bit: u32) -> bool {
        self.reg(CR1) & 1 != 0 && self.reg(CR1) >> bit & 1 != 0
    }

    fn baud(&self) -> f64 {
        self.kernel_hz as f64 * 256.0 / f64::from(self.reg(BRR).max(1))
    }

    fn byte_time(&self) -> u64 {
        units_per_cycle(self.baud() as u64).saturating_mul(10)
    }

    fn framed(&self) -> bool {
        (self.baud() / TERMINAL_BAUD - 1.0).abs() < 0.02
    }

    /// Types at the terminal.
    pub fn type_bytes(&mut self, bytes: &[u8], now: u64) {
        self.typed.extend(bytes);
        self.next_byte(now);
    }

    /// Number of typed bytes that have not arrived.
    pub fn waiting(&self) -> usize {
        self.typed.len()
    }

    fn next_byte(&mut self, now: u64) {
        if self.arrival.is_none() && !self.typed.is_empty() {
            let byte = 10 * units_per_cycle(TERMINAL_BAUD as u64);
            self.arrival = Some(now + byte);
            self.idle_at = None;
        }
    }

    pub fn read(&mut self, offset: u32) -> u32 {
        match offset {
            ISR => {
                let mut value = self.flags;
                value |= if self.on(3) { ISR_TEACK } else { 0 };
                value |= if self.on(2) { ISR_REACK } else { 0 };
                value |= if self.depth() > 1 && self.queued.is_empty() { ISR_TXFE } else { 0 };
                value |= u32::from(!self.received.is_empty()) << 5;
                value |= u32::from(self.queued.len() < self.depth()) << 7;
                value
            }
            RDR => self.received.pop_front().map_or(0, u32::from),
            _ => self.reg(offset),
        }
    }

    pub fn write(&mut self, offset: u32, value: u32, now: u64, kernel_hz: u64) {
        self.kernel_hz = kernel_hz;
        match offset {
            ICR => self.flags &= !(value & (ISR_IDLE | ISR_ORE | ISR_FE | ISR_TC)),
            TDR => {
                if self.on(3) && self.queued.len() < self.depth() {
                    self.queued.push_back(value as u8);
                    self.flags &= !ISR_TC;
                    self.send(now);
                }
            }
            _ => {
                if let Some(register) = self.regs.get_mut(offset as usize / 4) {
                    *register = value;
                }
            }
        }
    }

    /// Whether the DMA is asked for a byte.
    pub fn wants_to_send(&self) -> bool {
        self.on(3) && self.reg(CR3) & CR3_DMAT != 0 && self.queued.len() < self.depth()
    }

    fn send(&mut self, now: u64) {
        if self.sending.is_none()
            && let Some(byte) = self.queued.pop_front()
        {
            self.sending = Some((now.saturating_add(self.byte_time()), byte));
        }
    }

    pub fn advance(&mut self, now: u64) {
        while let Some((at, byte)) = self.sending
            && now >= at
        {
            self.shown.push_back(if self.framed() { byte } else { byte ^ 0x55 });
            self.sending = None;
            self.send(at);
            if self.sending.is_none() {
                self.flags |= ISR_TC;
            }
        }
        while let Some(at) = self.arrival
            && now >= at
        {
            self.arrival = None;
            if let Some(byte) = self.typed.pop_front()
                && self.on(2)
            {
                if self.received.len() >= self.depth() {
                    self.overruns += 1;
                    self.flags |= ISR_ORE;
                } else if self.framed() {
                    self.received.push_back(byte);
                } else {
                    self.flags |= ISR_FE;
                    self.received.push_back(byte ^ 0x55);
                }
            }
            self.next_byte(at);
            if self.arrival.is_none() && self.on(2) {
                self.idle_at = Some(at.saturating_add(self.byte_time()));
            }
        }
        if self.idle_at.is_some_and(|at| now >= at) {
            self.idle_at = None;
            self.flags |= ISR_IDLE;
        }
    }

    pub fn next_event(&self) -> u64 {
        let sent = self.sending.map_or(u64::MAX, |(at, _)| at);
        sent.min(self.arrival.unwrap_or(u64::MAX)).min(self.idle_at.unwrap_or(u64::MAX))
    }

    pub fn interrupt(&mut self) -> bool {
        let isr = self.read(ISR);
        let cr1 = self.reg(CR1);
        let errors = isr & (ISR_ORE | ISR_FE) != 0 && self.reg(CR3) & 1 != 0;
        let overrun = isr & ISR_ORE != 0 && cr1 >> 5 & 1 != 0;
        cr1 & 1 != 0 && (isr & cr1 & 0xf0 != 0 || errors || overrun)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn board() -> Lpuart {
        let mut uart = Lpuart::new();
        uart.write(BRR, 47_222, 0, 170_000_000);
        uart.write(CR1, 1 | 4 | 8 | 1 << 4 | 1 << 5, 0, 170_000_000);
        uart
    }

    #[test]
    fn bytes_arrive_singly_then_the_line_idles() {
        let mut uart = board();
        uart.type_bytes(b"ab", 0);
        assert!(!uart.interrupt());
        let mut text = Vec::new();
        while uart.next_event() != u64::MAX {
            let now = uart.next_event();
            uart.advance(now);
            if uart.read(ISR) & 1 << 5 != 0 {
                text.push(uart.read(RDR) as u8);
            }
        }
        assert_eq!(text, b"ab");
        assert_ne!(uart.read(ISR) & ISR_IDLE, 0);
        assert_eq!(uart.overruns, 0);
    }

    #[test]
    fn slow_reader_loses_bytes_and_wrong_rate_garbles() {
        let mut uart = board();
        uart.type_bytes(b"abc", 0);
        uart.advance(u64::MAX / 8);
        assert_eq!(uart.overruns, 2);
        let mut slow = board();
        slow.write(BRR, 50_000, 0, 170_000_000);
        slow.write(TDR, u32::from(b'x'), 0, 170_000_000);
        slow.advance(u64::MAX / 8);
        assert_ne!(slow.shown.front(), Some(&b'x'));
    }
}
