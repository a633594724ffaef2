//! A timer: time base, one-pulse mode, compare flags and outputs, encoder counter, capture on an internal trigger, trigger
//! output.
//!
//! Counts are computed from the start time and the length of a count, not stepped.

use std::cell::Cell;

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SMCR: u32 = 0x08;
const DIER: u32 = 0x0c;
const DIER_UDE: u32 = 1 << 8;
const SR: u32 = 0x10;
const EGR: u32 = 0x14;
const CCMR1: u32 = 0x18;
const CCMR2: u32 = 0x1c;
const CCER: u32 = 0x20;
const CNT: u32 = 0x24;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2c;
const CCR1: u32 = 0x34;
const CCR3: u32 = 0x3c;
const CCR4: u32 = 0x40;

/// Delay from a count in TIM2 to the capture in TIM5, timer cycles, from synchronisation at both ends of the trigger. It makes
/// the race between the two registers real for their reader. A test may choose another.
pub(crate) const CAPTURE_LAG_CYCLES: u64 = 4;

/// Timer of each internal trigger input, by TS [rm0440, "TIMx internal trigger connection"].
const TRIGGER_INPUTS: [(u32, u8); 7] = [(0, 1), (1, 2), (2, 3), (3, 4), (8, 5), (9, 8), (10, 15)];

#[derive(Debug)]
pub(crate) struct Tim {
    /// Time before which nothing changes by itself but the count.
    quiet_until: u64,
    /// Answer of `next_event`, until something changes.
    next: Cell<Option<u64>>,
    number: u8,
    wide: bool,
    regs: [u32; 64],
    /// Active prescaler. The register is preloaded.
    prescaler: u64,
    /// Virtual time and count at which counting began.
    origin: (u64, u64),
    /// Counts since the origin that were processed.
    seen: u64,
    /// Count in encoder mode.
    encoder: u32,
    /// A pending capture, with its time and value.
    pending: Option<(u64, u32)>,
    /// Units of virtual time in a cycle of the timer clock.
    cycle: u64,
}

impl Tim {
    pub fn new(number: u8) -> Self {
        let wide = matches!(number, 2 | 5);
        let mut regs = [0; 64];
        regs[ARR as usize / 4] = if wide { u32::MAX } else { 0xffff };
        Self {
            quiet_until: 0,
            next: Cell::new(None),
            number,
            wide,
            regs,
            prescaler: 1,
            origin: (0, 0),
            seen: 0,
            encoder: 0,
            pending: None,
            cycle: 16,
        }
    }

    fn reg(&self, offset: u32) -> u32 {
        self.regs.get(offset as usize / 4).copied().unwrap_or(0)
    }

    fn set(&mut self, offset: u32, value: u32) {
        if let Some(register) = self.regs.get_mut(offset as usize / 4) {
            *register = value;
        }
    }

    fn running(&self) -> bool {
        self.reg(CR1) & 1 != 0
    }

    /// CR1.OPM: the counter stops at its update.
    fn one_pulse(&self) -> bool {
        self.reg(CR1) & 8 != 0
    }

    /// Level of a channel's output, 1 to 4 [rm0440, "OC1M"]. Without its enable bit an output is low.
    pub fn output_high(&self, channel: u32, now: u64) -> bool {
        let k = channel - 1;
        let mode = self.reg(CCMR1 + 4 * (k / 2)) >> (8 * (k % 2));
        let (input, mode) = (mode & 3 != 0, mode >> 4 & 7 | (mode >> 16 & 1) << 3);
        let polarity = self.reg(CCER) >> (4 * k);
        if polarity & 1 == 0 || input {
            return false;
        }
        let below = self.count(now) < self.reg(CCR1 + 4 * k);
        let active = match mode {
            5 => true,
            6 => below,
            7 => !below,
            _ => false,
        };
        active != (polarity & 2 != 0)
    }

    fn slave_mode(&self) -> u32 {
        let smcr = self.reg(SMCR);
        smcr & 7 | (smcr >> 16 & 1) << 3
    }

    fn encoder_mode(&self) -> bool {
        matches!(self.slave_mode(), 1..=3)
    }

    fn trigger_output(&self) -> u32 {
        let cr2 = self.reg(CR2);
        cr2 >> 4 & 7 | (cr2 >> 25 & 1) << 3
    }

    /// Whether the trigger output pulses at every update.
    pub fn updates_trigger(&self) -> bool {
        self.trigger_output() == 2
    }

    /// Whether every update is a request to the DMA.
    pub fn updates_request(&self) -> bool {
        self.reg(DIER) & DIER_UDE != 0
    }

    fn count_length(&self) -> u64 {
        self.cycle.saturating_mul(self.prescaler)
    }

    fn modulus(&self) -> u64 {
        u64::from(self.reg(ARR)) + 1
    }

    /// Counts since zero, not wrapped.
    fn total(&self, now: u64) -> u64 {
        let (since, base) = self.origin;
        if !self.running() {
            return base;
        }
        let total = base + now.saturating_sub(since) / self.count_length();
        // stopped by its update, which `advance` has yet to process
        if self.one_pulse() { total.min((base / self.modulus() + 1) * self.modulus()) } else { total }
    }

    fn count(&self, now: u64) -> u32 {
        if self.encoder_mode() {
            return self.encoder;
        }
        (self.total(now) % self.modulus()) as u32
    }

    fn time_of_total(&self, total: u64) -> u64 {
        let (since, base) = self.origin;
        since.saturating_add(total.saturating_sub(base).saturating_mul(self.count_length()))
    }

    /// What comes by itself must be computed again.
    fn wake(&mut self) {
        self.quiet_until = 0;
        self.next.set(None);
    }

    fn restart(&mut self, now: u64, count: u32) {
        self.wake();
        self.origin = (now, u64::from(count));
        self.seen = u64::from(count);
    }

    /// The clock of the bus changed: a running counter goes on at the new rate.
    pub fn set_clock(&mut self, cycle: u64, now: u64) {
        if cycle != self.cycle {
            self.wake();
            self.origin = (now, self.total(now));
            self.cycle = cycle;
        }
    }

    pub fn read(&self, offset: u32, now: u64) -> u32 {
        match offset {
            CNT => self.count(now),
            PSC => self.reg(PSC) & 0xffff,
            _ => self.reg(offset),
        }
    }

    /// Reading a capture clears its flag.
    pub fn was_read(&mut self, offset: u32) {
        // the channels that capture here
        for (register, mode, flag) in [(CCR1, CCMR1, 1 << 1), (CCR3, CCMR2, 1 << 3)] {
            if offset == register && self.reg(mode) & 3 != 0 {
                let sr = self.reg(SR) & !flag;
                self.set(SR, sr);
            }
        }
    }

    pub fn write(&mut self, offset: u32, value: u32, now: u64, cycle: u64) {
        self.wake();
        match offset {
            CR1 => {
                let was = self.running();
                let count = self.count(now);
                self.set(CR1, value);
                if !was && self.running() {
                    self.cycle = cycle;
                    self.restart(now, count);
                } else if was && !self.running() {
                    self.restart(now, count);
                }
            }
            SR => {
                let sr = self.reg(SR) & value;
                self.set(SR, sr);
            }
            EGR => {
                if value & 1 != 0 {
                    self.prescaler = u64::from(self.reg(PSC) & 0xffff) + 1;
                    self.restart(now, 0);
                    if self.reg(CR1) & 4 == 0 {
                        let sr = self.reg(SR) | 1;
                        self.set(SR, sr);
                    }
                }
            }
            CNT => {
                self.encoder = value;
                self.restart(now, if self.wide { value } else { value & 0xffff });
            }
            ARR => {
                let count = self.count(now);
                self.set(ARR, if self.wide { value } else { value & 0xffff });
                self.restart(now, count);
            }
            _ => self.set(offset, value),
        }
    }

    /// Updates the flags to `now`. Returns the number of updates since the last call.
    pub fn advance(&mut self, now: u64) -> u64 {
        if self.is_quiet(now) {
            return 0;
        }
        self.next.set(None);
        let updates = self.process(now);
        self.quiet_until = self.next_change();
        updates
    }

    /// Whether nothing has changed up to this time.
    pub fn is_quiet(&self, now: u64) -> bool {
        now < self.quiet_until
    }

    fn process(&mut self, now: u64) -> u64 {
        if let Some((at, value)) = self.pending
            && now >= at
        {
            self.pending = None;
            let sr = self.reg(SR);
            // an unread capture is an overcapture
            self.set(SR, if sr & 2 != 0 { sr | 1 << 9 } else { sr | 2 });
            self.set(CCR1, value);
        }
        if !self.running() || self.encoder_mode() {
            return 0;
        }
        let (from, to) = (self.seen, self.total(now));
        if to == from {
            return 0;
        }
        let modulus = self.modulus();
        let updates = to / modulus - from / modulus;
        let mut sr = self.reg(SR) | u32::from(updates > 0);
        // capture channels have no compare
        for channel in u32::from(self.reg(CCMR1) & 3 != 0)..4 {
            let compare = u64::from(self.reg(CCR1 + 4 * channel));
            if compare < modulus && crossings(from, to, compare, modulus) {
                sr |= 2 << channel;
            }
        }
        self.set(SR, sr);
        self.seen = to;
        if updates > 0 && self.one_pulse() {
            let cr1 = self.reg(CR1) & !1;
            self.set(CR1, cr1);
            self.restart(now, 0);
        }
        updates
    }

    /// Time at which the counter next has this count, after the counts that were processed.
    fn time_of(&self, count: u64) -> u64 {
        let modulus = self.modulus();
        let mut total = self.seen / modulus * modulus + count;
        if total <= self.seen {
            total += modulus;
        }
        self.time_of_total(total)
    }

    /// Time of the next change of a flag, or of the next event if that is earlier.
    fn next_change(&self) -> u64 {
        let mut next = self.next_event();
        if self.running() && !self.encoder_mode() {
            next = next.min(self.time_of(0));
            for channel in 0..4 {
                let compare = u64::from(self.reg(CCR1 + 4 * channel));
                if compare < self.modulus() {
                    next = next.min(self.time_of(compare));
                }
            }
        }
        next
    }

    /// Time of the next event that matters.
    pub fn next_event(&self) -> u64 {
        if let Some(next) = self.next.get() {
            return next;
        }
        let mut next = self.pending.map_or(u64::MAX, |(at, _)| at);
        if self.running() && !self.encoder_mode() {
            let dier = self.reg(DIER);
            if dier & (1 | DIER_UDE) != 0 || self.updates_trigger() || self.one_pulse() {
                next = next.min(self.time_of(0));
            }
            for channel in 0..4 {
                if dier >> (channel + 1) & 1 != 0 {
                    next = next.min(self.time_of(u64::from(self.reg(CCR1 + 4 * channel))));
                }
            }
        }
        self.next.set(Some(next));
        next
    }

    pub fn interrupt(&self) -> bool {
        self.reg(SR) & self.reg(DIER) & 0x5f != 0
    }

    /// Counts an edge of the encoder. True if the trigger output passes it on.
    pub fn encoder_edge(&mut self, up: bool) -> bool {
        let inputs = self.reg(CCMR1);
        // mode 3 counts every edge; the other modes are not modelled and count nothing
        let counts = self.running() && self.slave_mode() == 3 && inputs & 3 == 1 && inputs >> 8 & 3 == 1;
        if !counts {
            return false;
        }
        self.encoder = if up { self.encoder.wrapping_add(1) } else { self.encoder.wrapping_sub(1) };
        let cr1 = self.reg(CR1) & !0x10 | u32::from(!up) << 4;
        self.set(CR1, cr1);
        self.trigger_output() == 8
    }

    /// A rising edge on the input of channel 3 captures the count.
    pub fn index_edge(&mut self) {
        if self.running() && self.reg(CCMR2) & 3 == 1 && self.reg(CCER) >> 8 & 0b1011 == 1 {
            let sr = self.reg(SR);
            // an unread capture is an overcapture
            self.set(SR, if sr & 1 << 3 != 0 { sr | 1 << 11 } else { sr | 1 << 3 });
            self.set(CCR3, self.encoder);
        }
    }

    /// Counts that are lost or made up, as by dirt.
    pub fn slip(&mut self, counts: i32) {
        self.encoder = self.encoder.wrapping_add_signed(counts);
    }

    /// Replaces the count.
    pub fn replace_count(&mut self, count: u32) {
        self.encoder = count;
    }

    /// Shifts the count by `skew`, and captures an edge `age` counts ago.
    pub fn replace_capture(&mut self, now: u64, skew: u32, age: Option<u32>) {
        self.wake();
        let count = self.count(now).wrapping_add(skew);
        if skew != 0 {
            self.restart(now, count);
        }
        if let Some(age) = age {
            self.set(CCR1, count.wrapping_sub(age));
        }
    }

    /// A pulse on the trigger output of another timer, at `at`.
    pub fn trigger_input(&mut self, from: u8, at: u64, lag_cycles: u64) {
        let smcr = self.reg(SMCR);
        let selected = smcr >> 4 & 7 | (smcr >> 20 & 3) << 3;
        let source = TRIGGER_INPUTS.iter().find(|(code, _)| *code == selected).map(|(_, timer)| *timer);
        let captures = self.reg(CCMR1) & 3 == 3 && self.reg(CCER) & 1 != 0;
        if source == Some(from) && captures && self.running() && self.number != from {
            self.wake();
            let at = at + lag_cycles * self.cycle;
            self.pending = Some((at, self.count(at)));
        }
    }

    /// Highest offset of a capture or compare register.
    pub fn is_capture(offset: u32) -> bool {
        (CCR1..=CCR4).contains(&offset)
    }
}

/// Whether a counter that went from `from` to `to` counts passed `compare` modulo `modulus`.
fn crossings(from: u64, to: u64, compare: u64, modulus: u64) -> bool {
    let passed = |total: u64| (total + modulus - compare) / modulus;
    passed(to) > passed(from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prescaler_and_reload_make_the_period() {
        let mut tim6 = Tim::new(6);
        tim6.write(PSC, 3, 0, 16);
        tim6.write(ARR, 42_499, 0, 16);
        tim6.write(EGR, 1, 0, 16);
        tim6.write(CR2, 2 << 4, 0, 16);
        tim6.write(CR1, 1, 100, 16);
        assert_eq!(tim6.next_event(), 100 + 2_720_000);
        assert_eq!(tim6.advance(100 + 2_719_999), 0);
        assert_eq!(tim6.advance(100 + 2_720_000), 1);
        assert_eq!(tim6.next_event(), 100 + 2 * 2_720_000);
        assert_eq!(tim6.read(CNT, 100 + 2_720_000 + 64 * 7), 7);
    }

    #[test]
    fn without_update_event_the_prescaler_is_not_loaded() {
        let mut tim6 = Tim::new(6);
        tim6.write(PSC, 3, 0, 16);
        tim6.write(CR1, 1, 0, 16);
        assert_eq!(tim6.read(CNT, 1600), 100);
    }

    #[test]
    fn capture_needs_the_right_trigger_input() {
        for (ts, ccs, captured) in [(1u32, 3u32, true), (0, 3, false), (1, 1, false)] {
            let mut tim5 = Tim::new(5);
            tim5.write(SMCR, ts << 4, 0, 16);
            tim5.write(CCMR1, ccs, 0, 16);
            tim5.write(CCER, 1, 0, 16);
            tim5.write(CR1, 1, 0, 16);
            tim5.trigger_input(2, 16_000, CAPTURE_LAG_CYCLES);
            tim5.advance(16_000 + 64);
            assert_eq!(tim5.read(CCR1, 17_000), if captured { 1004 } else { 0 });
        }
    }

    #[test]
    fn one_pulse_ends_unless_rearmed() {
        let mut tim3 = Tim::new(3);
        tim3.write(ARR, 99, 0, 10);
        tim3.write(CCR1 + 4, 1, 0, 10);
        tim3.write(CCMR1, 7 << 12, 0, 10);
        assert!(!tim3.output_high(2, 0), "not enabled");
        tim3.write(CCER, 1 << 4, 0, 10);
        assert!(!tim3.output_high(2, 0), "at count 0");
        tim3.write(CNT, 1, 0, 10);
        tim3.write(CR1, 8 | 1, 0, 10);
        assert!(tim3.output_high(2, 0) && tim3.output_high(2, 985));
        assert_eq!(tim3.next_event(), 990);
        assert!(!tim3.output_high(2, 990));
        // rearmed half way
        tim3.write(CNT, 1, 500, 10);
        assert_eq!(tim3.advance(1_400), 0);
        assert!(tim3.output_high(2, 1_400));
        assert_eq!(tim3.advance(1_490), 1);
        assert!(!tim3.output_high(2, 1_490) && !tim3.output_high(2, 9_000));
        assert_eq!((tim3.read(CR1, 9_000) & 1, tim3.read(CNT, 9_000)), (0, 0));
        // forced low while it counts
        tim3.write(CNT, 1, 10_000, 10);
        tim3.write(CR1, 8 | 1, 10_000, 10);
        assert!(tim3.output_high(2, 10_100));
        tim3.write(CCMR1, 4 << 12, 10_100, 10);
        assert!(!tim3.output_high(2, 10_100));
    }

    #[test]
    fn compare_flags_follow_the_counter_round() {
        assert!(crossings(0, 5, 5, 10));
        assert!(!crossings(5, 9, 5, 10));
        assert!(crossings(9, 10, 0, 10));
        assert!(crossings(12, 16, 5, 10));
    }
}
