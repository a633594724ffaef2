//! ADC1: the injected sequence with its trigger, sampling times, oversampling and clock; one regular conversion at a time, which
//! ends at once.

use crate::{UNITS_PER_MS, units_per_cycle};

const ISR: u32 = 0x00;
const IER: u32 = 0x04;
const CR: u32 = 0x08;
const CFGR: u32 = 0x0c;
const CFGR2: u32 = 0x10;
const SMPR1: u32 = 0x14;
const SMPR2: u32 = 0x18;
const JSQR: u32 = 0x4c;
const TR1: u32 = 0x20;
const TR2: u32 = 0x24;
const TR3: u32 = 0x28;
const SQR1: u32 = 0x30;
const DR: u32 = 0x40;
const JDR1: u32 = 0x80;
const CALFACT: u32 = 0xb4;
const CCR: u32 = 0x308;

/// Input of the internal reference, and what the factory reads of it at 3.0 V, a code of 12 bits.
pub(crate) const REFERENCE: u32 = 18;
pub(crate) const FACTORY_REFERENCE: u16 = 1654;
/// Shortest sampling time of the reference, ns [ds12288, "Embedded internal voltage reference"].
const REFERENCE_NS: u64 = 4_000;

/// What a calibration finds.
const CALIBRATED: u32 = 0x40;

/// Timer trigger outputs among the injected triggers of ADC1 [rm0440, "ADC1 external triggers for injected channels"]:
/// (JEXTSEL, timer).
pub(crate) const TRIGGERS: [(u32, u8); 9] =
    [(0, 1), (2, 2), (5, 4), (9, 8), (12, 3), (14, 6), (15, 15), (16, 20), (30, 7)];
const PRESCALERS: [u64; 12] = [1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256];
/// Sampling times in half cycles.
const SAMPLING: [u64; 8] = [5, 13, 25, 49, 95, 185, 495, 1281];
/// Pause after which the first conversion is wrong, units. The errata give 1 ms; a control period is as long.
const LONG_IDLE: u64 = UNITS_PER_MS / 10;
/// Fastest clock the data sheet allows, Hz.
const MAX_HZ: u64 = 60_000_000;

/// Result of a trigger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Triggered {
    Ignored,
    Started,
    /// The previous sequence was still running: the trigger is lost.
    Busy,
}

#[derive(Debug)]
pub(crate) struct Adc {
    regs: [u32; 256],
    /// End of the running sequence and its results.
    running: Option<(u64, [u16; 4])>,
    /// End of the last conversion.
    idle_since: u64,
    pub violation: Option<String>,
}

impl Adc {
    pub fn new() -> Self {
        let mut adc = Self { regs: [0; 256], running: None, idle_since: 0, violation: None };
        adc.set(CR, 1 << 29);
        adc.set(CFGR, 1 << 31);
        // thresholds of the watchdogs
        adc.set(TR1, 0x0fff_0000);
        adc.set(TR2, 0x00ff_0000);
        adc.set(TR3, 0x00ff_0000);
        adc
    }

    fn reg(&self, offset: u32) -> u32 {
        self.regs.get(offset as usize / 4).copied().unwrap_or(0)
    }

    fn set(&mut self, offset: u32, value: u32) {
        if let Some(register) = self.regs.get_mut(offset as usize / 4) {
            *register = value;
        }
    }

    pub fn read(&self, offset: u32) -> u32 {
        self.reg(offset)
    }

    /// True when the end-of-sequence flag was cleared.
    pub fn write(&mut self, offset: u32, value: u32) -> bool {
        match offset {
            ISR => {
                let isr = self.reg(ISR);
                self.set(ISR, isr & !value);
                return isr & value & 1 << 6 != 0;
            }
            CR => self.control(value),
            // settings are frozen while conversions may start
            CFGR | CFGR2 | SMPR1 | SMPR2 if self.reg(CR) & 0xc != 0 => {}
            JDR1..=0x8c => {}
            _ => self.set(offset, value),
        }
        false
    }

    fn control(&mut self, value: u32) {
        let old = self.reg(CR);
        // calibration and ADDIS act at once; stops withdraw starts
        let mut new = value & !(1 << 31);
        if value & 1 << 31 != 0 && old & 1 == 0 {
            self.set(CALFACT, CALIBRATED);
        }
        if value & 2 != 0 {
            new &= !3;
        }
        if value & 0x20 != 0 {
            new &= !0x28;
            self.running = None;
        }
        if value & 0x10 != 0 {
            new &= !0x14;
        }
        // ADEN and the starts are set-only
        new |= old & 0xd & !(if value & 2 != 0 { 1 } else { 0 }) & !(if value & 0x20 != 0 { 8 } else { 0 });
        let regulator_on = new & 1 << 28 != 0 && new & 1 << 29 == 0;
        if new & 1 != 0 && regulator_on {
            let isr = self.reg(ISR) | 1;
            self.set(ISR, isr);
        }
        self.set(CR, new);
    }

    /// A regular conversion that was asked for. `level` as in [`Self::trigger`].
    pub fn convert(&mut self, kernel_hz: u64, level: impl Fn(u32) -> u16) {
        let cr = self.reg(CR);
        let clock = self.clock(kernel_hz);
        if cr & 5 != 5 || clock == 0 {
            return;
        }
        let channel = self.reg(SQR1) >> 6 & 0x1f;
        let (ratio, shift) = self.oversampling(1);
        let on = channel != REFERENCE || self.reg(CCR) >> 22 & 1 != 0;
        if channel == REFERENCE && self.sampling(channel) * 500_000_000 / clock < REFERENCE_NS {
            self.violation = Some("ADC1 samples the internal reference for less than 4 us".into());
        }
        let sum = if on { (u64::from(level(channel)) * ratio) >> 4 } else { 0 };
        self.set(DR, (sum.min(ratio * 4095) >> shift) as u32);
        self.set(ISR, self.reg(ISR) | 0xc);
        self.set(CR, cr & !4);
    }

    /// Ratio and shift of the conversions that this bit of CFGR2 oversamples: 1 for regular ones, 2 for injected ones.
    fn oversampling(&self, which: u32) -> (u64, u32) {
        let cfgr2 = self.reg(CFGR2);
        if cfgr2 & which == 0 { (1, 0) } else { (2 << (cfgr2 >> 2 & 7), cfgr2 >> 5 & 0xf) }
    }

    /// A timer's trigger output. `level` gives the 16-bit level of an input, 0xffff at the reference.
    pub fn trigger(&mut self, timer: u8, now: u64, kernel_hz: u64, level: impl Fn(u32) -> u16) -> Triggered {
        let jsqr = self.reg(JSQR);
        let selected = TRIGGERS.iter().any(|&(code, t)| t == timer && code == jsqr >> 2 & 0x1f);
        let armed = self.reg(CR) & 9 == 9 && jsqr >> 7 & 1 != 0;
        let clock = self.clock(kernel_hz);
        if !(selected && armed && clock > 0) {
            return Triggered::Ignored;
        }
        if self.running.is_some() {
            return Triggered::Busy;
        }
        if clock > MAX_HZ {
            self.violation = Some(format!("ADC1 clocked at {clock} Hz, more than {MAX_HZ} Hz"));
        }
        if self.reg(CALFACT) == 0 {
            self.violation = Some("ADC1 used without its calibration".into());
        }
        let (ratio, shift) = self.oversampling(2);
        let mut half_cycles = 0;
        let mut results = [0; 4];
        for (rank, result) in results.iter_mut().enumerate().take((jsqr & 3) as usize + 1) {
            let channel = jsqr >> (9 + 6 * rank) & 0x1f;
            half_cycles += ratio * (self.sampling(channel) + 25);
            // the sum of `ratio` 12-bit conversions of a level that dithers across the last bits
            let mut sum = (u64::from(level(channel)) * ratio) >> 4;
            if rank == 0 && now.saturating_sub(self.idle_since) > LONG_IDLE {
                // the first of the conversions gives nothing
                sum -= sum / ratio;
            }
            let most = ratio * 4095;
            *result = (sum.min(most) >> shift) as u16;
        }
        let end = now + half_cycles * units_per_cycle(clock) / 2;
        self.running = Some((end, results));
        Triggered::Started
    }

    fn sampling(&self, channel: u32) -> u64 {
        let (register, position) = if channel <= 9 { (SMPR1, channel) } else { (SMPR2, channel - 10) };
        SAMPLING[(self.reg(register) >> (3 * position) & 7) as usize]
    }

    fn clock(&self, kernel_hz: u64) -> u64 {
        let ccr = self.reg(CCR);
        // the synchronous modes are not modelled: no clock
        if ccr >> 16 & 3 != 0 {
            return 0;
        }
        PRESCALERS.get((ccr >> 18 & 0xf) as usize).map_or(0, |divider| kernel_hz / divider)
    }

    pub fn next_event(&self) -> u64 {
        self.running.map_or(u64::MAX, |(end, _)| end)
    }

    /// Ends a sequence that is due. `Some(true)`: the last one was not served and its samples are lost.
    pub fn advance(&mut self, now: u64) -> Option<bool> {
        let (end, results) = self.running?;
        if now < end {
            return None;
        }
        self.running = None;
        self.idle_since = end;
        for (rank, result) in results.into_iter().enumerate() {
            self.set(JDR1 + 4 * rank as u32, u32::from(result));
        }
        let isr = self.reg(ISR);
        self.set(ISR, isr | 0x60);
        Some(isr & 1 << 6 != 0)
    }

    /// Replaces the last two results of the sequence.
    pub fn replace(&mut self, results: [u16; 2]) {
        let last = self.reg(JSQR) & 3;
        for (back, result) in results.into_iter().rev().enumerate() {
            self.set(JDR1 + 4 * last.saturating_sub(back as u32), u32::from(result));
        }
    }

    pub fn interrupt(&self) -> bool {
        self.reg(ISR) & self.reg(IER) & 0x7ff != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn board() -> Adc {
        let mut adc = Adc::new();
        adc.write(CR, 1 << 28);
        adc.write(CR, 1 << 28 | 1 << 31);
        adc.write(CR, 1 << 28 | 1);
        adc.write(CCR, 2 << 18);
        adc.write(CFGR2, 2 | 3 << 2);
        adc.write(SMPR1, 1 << 18 | 1 << 21);
        adc.write(JSQR, 1 | 14 << 2 | 1 << 7 | 6 << 9 | 7 << 15);
        adc.write(CR, 1 << 28 | 9);
        adc
    }

    #[test]
    fn oversampled_pair_takes_14_us() {
        let mut adc = board();
        let level = |channel| if channel == 6 { 40_000 } else { 65_535 };
        assert_eq!(adc.trigger(6, 0, 170_000_000, level), Triggered::Started);
        let us = adc.next_event() as f64 / crate::UNITS_PER_SECOND as f64 * 1e6;
        println!("pair of 16 conversions: {us:.2} us");
        assert!((us - 14.3).abs() < 0.1);
        assert_eq!(adc.trigger(6, 1, 170_000_000, level), Triggered::Busy);
        assert_eq!(adc.advance(adc.next_event()), Some(false));
        assert_eq!((adc.read(JDR1), adc.read(JDR1 + 4)), (40_000, 65_520));
        assert_eq!(adc.violation, None);
        // after a period without conversions the first one is wrong
        assert_eq!(adc.trigger(6, UNITS_PER_MS, 170_000_000, level), Triggered::Started);
        adc.advance(adc.next_event());
        assert_eq!((adc.read(JDR1), adc.read(JDR1 + 4)), (37_500, 65_520));
    }

    #[test]
    fn the_reference_reads_as_in_the_factory_at_3_volt() {
        let mut adc = board();
        adc.write(CR, 1 << 28 | 1 | 0x20);
        adc.write(CFGR2, 1 | 3 << 2);
        adc.write(SQR1, REFERENCE << 6);
        let read = |adc: &mut Adc| {
            adc.write(CR, 1 << 28 | 5);
            adc.convert(170_000_000, |_| FACTORY_REFERENCE << 4);
            (adc.read(DR), adc.read(ISR) & 0xc, adc.violation.take())
        };
        let (off, done, too_short) = read(&mut adc);
        assert_eq!((off, done), (0, 0xc), "the reference is off");
        assert!(too_short.is_some());
        adc.write(CCR, 2 << 18 | 1 << 22);
        adc.write(SMPR2, 6 << 24);
        assert_eq!(read(&mut adc), (16 * u32::from(FACTORY_REFERENCE), 0xc, None));
    }

    #[test]
    fn wrong_trigger_wrong_clock_wrong_ratio_show() {
        let level = |_| 40_000;
        assert_eq!(board().trigger(7, 0, 170_000_000, level), Triggered::Ignored);
        assert_eq!(board().trigger(6, 0, 0, level), Triggered::Ignored, "no kernel clock selected");
        let mut fast = board();
        fast.write(CCR, 0);
        assert_eq!(fast.trigger(6, 0, 170_000_000, level), Triggered::Started);
        assert!(fast.violation.is_some());
        let mut single = Adc::new();
        single.write(CR, 1 << 28 | 1);
        single.write(CCR, 2 << 18);
        single.write(JSQR, 14 << 2 | 1 << 7 | 6 << 9);
        single.write(CR, 1 << 28 | 9);
        single.write(CFGR2, 2 | 3 << 2);
        assert_eq!(single.read(CFGR2), 0, "settings are frozen once started");
        single.trigger(6, 0, 170_000_000, level);
        single.advance(u64::MAX);
        assert_eq!(single.read(JDR1), 2500);
    }
}
