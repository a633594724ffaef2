//! Reset and clock control: oscillators (which start at once), clock security, PLL, switch, enables and resets.

use std::cell::Cell;

const CR: u32 = 0x00;
const ICSCR: u32 = 0x04;
const CFGR: u32 = 0x08;
const PLLCFGR: u32 = 0x0c;
const CIFR: u32 = 0x1c;
const CICR: u32 = 0x20;
const AHB1ENR: u32 = 0x48;
const APB1ENR1: u32 = 0x58;
const AHB1SMENR: u32 = 0x68;
const AHB2SMENR: u32 = 0x6c;
const AHB3SMENR: u32 = 0x70;
const APB1SMENR1: u32 = 0x78;
const APB1SMENR2: u32 = 0x7c;
const APB2SMENR: u32 = 0x80;
const CCIPR: u32 = 0x88;
const BDCR: u32 = 0x90;
const CSR: u32 = 0x94;
const CRRCR: u32 = 0x98;

const HSI_HZ: u64 = 16_000_000;
/// Crystal of the board's X3.
const HSE_HZ: u64 = 24_000_000;
/// Flags of an oscillator that failed, and the bits of CR around it.
const CIFR_CSSF: u32 = 1 << 8;
const CR_CSSON: u32 = 1 << 19;
const CR_HSEON: u32 = 1 << 16;
const CR_PLLON: u32 = 1 << 24;
/// Highest clock to which the core may switch with an undivided AHB [rm0440, "System clock (SYSCLK) selection"].
const UNDIVIDED_HZ: u64 = 80_000_000;

/// Reason of a reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResetCause {
    /// Power came up.
    PowerOn,
    /// The independent watchdog ran out.
    Watchdog,
    /// The firmware asked for it.
    Software,
    /// The reset pin: the button.
    Pin,
    /// A debugger, by the same register as the firmware.
    Debugger,
    /// A debugger that held the core while the watchdog ran out, as when a chip is flashed.
    DebuggerAfterWatchdog,
    /// The option bytes were loaded.
    OptionBytes,
    /// The window watchdog.
    WindowWatchdog,
    /// A forbidden low-power mode.
    LowPower,
}

impl ResetCause {
    fn flags(self) -> u32 {
        // every reset pulls the pin
        (1 << 26)
            | match self {
                Self::PowerOn => 1 << 27,
                Self::Watchdog => 1 << 29,
                Self::Software | Self::Debugger => 1 << 28,
                Self::Pin => 0,
                Self::DebuggerAfterWatchdog => 1 << 28 | 1 << 29,
                Self::OptionBytes => 1 << 25,
                Self::WindowWatchdog => 1 << 30,
                Self::LowPower => 1 << 31,
            }
    }
}

/// A peripheral's enable bit: (offset of its register, bit).
pub(crate) type Gate = (u32, u32);

#[derive(Debug)]
pub(crate) struct Rcc {
    regs: [u32; 256],
    /// Whether the crystal oscillates once it is switched on.
    crystal: bool,
    /// Deviation of the internal oscillator, parts in 10 000.
    hsi_error: i64,
    /// Units per cycle of the core, unless a setting has changed since.
    units: Cell<Option<u64>>,
    /// The clock security system interrupts.
    pub nmi: bool,
    pub violation: Option<String>,
}

impl Rcc {
    pub fn new(cause: ResetCause) -> Self {
        let mut regs = [0; 256];
        for (offset, value) in [
            (CR, 0x500),
            (ICSCR, 0x4000_0000),
            (CFGR, 0x5),
            (PLLCFGR, 0x1000),
            // flash, and the bus of the real-time clock
            (AHB1ENR, 0x100),
            (APB1ENR1, 0x400),
            // asleep, everything has its clock
            (AHB1SMENR, 0x130f),
            (AHB2SMENR, 0x050f_667f),
            (AHB3SMENR, 0x101),
            (APB1SMENR1, 0xd2fe_cd3f),
            (APB1SMENR2, 0x103),
            (APB2SMENR, 0x0437_f801),
            (CSR, cause.flags()),
        ] {
            regs[offset as usize / 4] = value;
        }
        Self { regs, crystal: true, hsi_error: 0, units: Cell::new(None), nmi: false, violation: None }
    }

    /// Resets the registers. The oscillators remain what they are.
    pub fn reset(&mut self, cause: ResetCause) {
        *self = Self { crystal: self.crystal, hsi_error: self.hsi_error, ..Self::new(cause) };
    }

    /// The crystal stops, or oscillates again. A core that it clocks goes on with the internal oscillator if clock security is
    /// on, and stops otherwise.
    pub fn set_crystal(&mut self, oscillates: bool) {
        self.crystal = oscillates;
        self.units.set(None);
        let cr = self.reg(CR);
        if !oscillates && cr & CR_CSSON != 0 && cr & CR_HSEON != 0 {
            let of_pll = self.reg(PLLCFGR) & 3 == 3;
            let off = CR_HSEON | CR_CSSON | if of_pll { CR_PLLON } else { 0 };
            self.set(CR, cr & !off);
            let cfgr = self.reg(CFGR);
            if cfgr & 3 == 2 || cfgr & 3 == 3 && of_pll {
                self.set(CFGR, cfgr & !3 | 1);
            }
            self.set(CIFR, CIFR_CSSF);
            self.nmi = true;
        }
    }

    /// Sets the deviation of the internal oscillator, parts in 10 000.
    pub fn set_hsi_error(&mut self, parts: i64) {
        self.hsi_error = parts;
        self.units.set(None);
    }

    /// Internal oscillator, Hz.
    fn hsi(&self) -> u64 {
        HSI_HZ.saturating_add_signed((HSI_HZ / 10_000) as i64 * self.hsi_error)
    }

    /// Crystal, Hz; 0 while it does not oscillate.
    fn hse(&self) -> u64 {
        if self.crystal && self.reg(CR) & CR_HSEON != 0 { HSE_HZ } else { 0 }
    }

    fn reg(&self, offset: u32) -> u32 {
        self.regs.get(offset as usize / 4).copied().unwrap_or(0)
    }

    fn set(&mut self, offset: u32, value: u32) {
        self.units.set(None);
        if let Some(register) = self.regs.get_mut(offset as usize / 4) {
            *register = value;
        }
    }

    pub fn read(&self, offset: u32) -> u32 {
        let value = self.reg(offset);
        let ready = |value: u32, on: u32, ready: u32| (value & !(1 << ready)) | ((value >> on) & 1) << ready;
        match offset {
            CR => {
                let value = ready(ready(ready(value, 8, 10), 16, 17), 24, 25);
                if self.hse() == 0 { value & !(1 << 17) } else { value }
            }
            CFGR => (value & !0xc) | (value & 3) << 2,
            BDCR | CRRCR | CSR => ready(value, 0, 1),
            _ => value,
        }
    }

    pub fn write(&mut self, offset: u32, value: u32) {
        let value = match offset {
            // RMVF clears the flags; they cannot be written
            CSR if value & (1 << 23) != 0 => value & 1,
            CSR => (value & 1) | (self.reg(CSR) & 0xff00_0000),
            // clock security lasts until the crystal fails or the chip resets
            CR => value | (self.reg(CR) & CR_CSSON),
            _ => value,
        };
        if offset == CICR && value & CIFR_CSSF != 0 {
            self.set(CIFR, 0);
        }
        let before = self.hclk();
        self.set(offset, value);
        let now = self.hclk();
        if offset == CFGR && before <= UNDIVIDED_HZ && now > UNDIVIDED_HZ && now == self.sysclk() {
            self.violation = Some(format!("switched from {before} to {now} Hz with an undivided AHB"));
        }
    }

    /// Frequency of the core clock before the AHB divider, Hz.
    fn sysclk(&self) -> u64 {
        match self.reg(CFGR) & 3 {
            1 => self.hsi(),
            2 => self.hse(),
            3 => self.pll_r(),
            _ => 0,
        }
    }

    fn pll_r(&self) -> u64 {
        let r = self.reg(PLLCFGR);
        let source = match r & 3 {
            2 => self.hsi(),
            3 => self.hse(),
            _ => 0,
        };
        let running = self.reg(CR) & (1 << 24) != 0 && r & (1 << 24) != 0;
        let (m, n) = (u64::from(r >> 4 & 0xf) + 1, u64::from(r >> 8 & 0x7f));
        let divider = 2 * (u64::from(r >> 25 & 3) + 1);
        if running { source / m * n / divider } else { 0 }
    }

    /// Core clock, Hz.
    pub fn hclk(&self) -> u64 {
        let divider = match self.reg(CFGR) >> 4 & 0xf {
            code @ 8..=11 => 1 << (code - 7),
            code @ 12..=15 => 1 << (code - 6),
            _ => 1,
        };
        self.sysclk() / divider
    }

    /// Units of virtual time per cycle of the core.
    pub fn units_per_cycle(&self) -> u64 {
        let units = self.units.get().unwrap_or_else(|| crate::units_per_cycle(self.hclk()));
        self.units.set(Some(units));
        units
    }

    /// Clock of the APB1 peripherals, Hz.
    pub fn pclk1(&self) -> u64 {
        self.hclk() / self.apb1_divider()
    }

    fn apb1_divider(&self) -> u64 {
        match self.reg(CFGR) >> 8 & 7 {
            code @ 4..=7 => 2 << (code - 4),
            _ => 1,
        }
    }

    /// Clock of the timers on APB1, Hz: twice the bus clock when that is divided.
    pub fn timer1(&self) -> u64 {
        if self.apb1_divider() == 1 { self.hclk() } else { 2 * self.pclk1() }
    }

    /// Kernel clock of ADC1 and ADC2, Hz; 0 when none is selected.
    pub fn adc12(&self) -> u64 {
        match self.reg(CCIPR) >> 28 & 3 {
            2 => self.sysclk(),
            _ => 0,
        }
    }

    /// Kernel clock of LPUART1, Hz.
    pub fn lpuart1(&self) -> u64 {
        match self.reg(CCIPR) >> 10 & 3 {
            0 => self.pclk1(),
            1 => self.sysclk(),
            2 => self.hsi(),
            _ => 32_768,
        }
    }

    pub fn enabled(&self, (offset, bit): Gate) -> bool {
        self.reg(offset) >> bit & 1 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pll_of_the_board_makes_170_mhz() {
        let mut rcc = Rcc::new(ResetCause::PowerOn);
        assert_eq!(rcc.hclk(), 16_000_000);
        rcc.write(PLLCFGR, 2 | 3 << 4 | 85 << 8 | 1 << 24);
        rcc.write(CFGR, 3);
        assert_eq!(rcc.hclk(), 0, "switched to a PLL that does not run");
        rcc.write(CR, 0x500 | 1 << 24);
        assert_eq!(rcc.hclk(), 170_000_000);
        assert_eq!(rcc.read(CFGR) >> 2 & 3, 3);
        rcc.write(CFGR, 3 | 4 << 8);
        assert_eq!((rcc.pclk1(), rcc.timer1()), (85_000_000, 170_000_000));
    }

    #[test]
    fn a_crystal_that_stops_leaves_the_internal_oscillator_only_with_clock_security() {
        for security in [true, false] {
            let mut rcc = Rcc::new(ResetCause::PowerOn);
            rcc.write(CR, 0x500 | CR_HSEON | if security { CR_CSSON } else { 0 });
            assert_ne!(rcc.read(CR) & 1 << 17, 0);
            rcc.write(PLLCFGR, 3 | 5 << 4 | 85 << 8 | 1 << 24);
            rcc.write(CR, rcc.read(CR) | CR_PLLON);
            rcc.write(CFGR, 3 | 8 << 4);
            rcc.write(CFGR, 3);
            assert_eq!((rcc.hclk(), rcc.violation.take()), (170_000_000, None));
            rcc.set_crystal(false);
            assert_eq!((rcc.hclk(), rcc.nmi), if security { (16_000_000, true) } else { (0, false) });
            assert_eq!(rcc.read(CIFR) & CIFR_CSSF != 0, security);
            rcc.reset(ResetCause::Software);
            rcc.write(CR, 0x500 | CR_HSEON);
            assert_eq!(rcc.read(CR) & 1 << 17, 0, "still dead after the reset");
        }
    }

    #[test]
    fn a_switch_beyond_80_mhz_needs_a_divided_ahb() {
        let mut rcc = Rcc::new(ResetCause::PowerOn);
        rcc.write(PLLCFGR, 2 | 3 << 4 | 85 << 8 | 1 << 24);
        rcc.write(CR, 0x500 | CR_PLLON);
        rcc.write(CFGR, 3);
        assert!(rcc.violation.is_some());
    }

    #[test]
    fn reset_flags_tell_the_cause_until_removed() {
        let mut rcc = Rcc::new(ResetCause::Watchdog);
        assert_ne!(rcc.read(CSR) & 1 << 29, 0);
        rcc.write(CSR, 1 << 23);
        assert_eq!(rcc.read(CSR), 0);
    }
}
