//! Reset and clock control: oscillators (which start at once), PLL, switch, enables and resets.

use std::collections::HashMap;

const CR: u32 = 0x00;
const CFGR: u32 = 0x08;
const PLLCFGR: u32 = 0x0c;
const CCIPR: u32 = 0x88;
const BDCR: u32 = 0x90;
const CSR: u32 = 0x94;
const CRRCR: u32 = 0x98;

const HSI_HZ: u64 = 16_000_000;
/// Crystal of the board's X3.
const HSE_HZ: u64 = 24_000_000;

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
    regs: HashMap<u32, u32>,
}

impl Rcc {
    pub fn new(cause: ResetCause) -> Self {
        let regs = HashMap::from([(CR, 0x500), (CFGR, 0x5), (PLLCFGR, 0x1000), (CSR, cause.flags())]);
        Self { regs }
    }

    fn reg(&self, offset: u32) -> u32 {
        self.regs.get(&offset).copied().unwrap_or(0)
    }

    pub fn read(&self, offset: u32) -> u32 {
        let value = self.reg(offset);
        let ready = |value: u32, on: u32, ready: u32| (value & !(1 << ready)) | ((value >> on) & 1) << ready;
        match offset {
            CR => ready(ready(ready(value, 8, 10), 16, 17), 24, 25),
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
            _ => value,
        };
        self.regs.insert(offset, value);
    }

    /// Frequency of the core clock before the AHB divider, Hz.
    fn sysclk(&self) -> u64 {
        match self.reg(CFGR) & 3 {
            1 => HSI_HZ,
            2 => HSE_HZ,
            3 => self.pll_r(),
            _ => 0,
        }
    }

    fn pll_r(&self) -> u64 {
        let r = self.reg(PLLCFGR);
        let source = match r & 3 {
            2 => HSI_HZ,
            3 => HSE_HZ,
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
            2 => HSI_HZ,
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
    fn reset_flags_tell_the_cause_until_removed() {
        let mut rcc = Rcc::new(ResetCause::Watchdog);
        assert_ne!(rcc.read(CSR) & 1 << 29, 0);
        rcc.write(CSR, 1 << 23);
        assert_eq!(rcc.read(CSR), 0);
    }
}
