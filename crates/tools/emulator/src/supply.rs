//! The supply: voltage detector (PWR) and its line of the EXTI.

const PWR_CR1: u32 = 0x00;
const PWR_CR2: u32 = 0x04;
const PWR_CR3: u32 = 0x08;
const PWR_SR2: u32 = 0x14;
const PWR_CR5: u32 = 0x80;
/// Range 1 without boost.
const CR5_R1MODE: u32 = 1 << 8;
const EXTI_IMR1: u32 = 0x00;
const EXTI_IMR2: u32 = 0x20;
const EXTI_RTSR1: u32 = 0x08;
const EXTI_FTSR1: u32 = 0x0c;
const EXTI_PR1: u32 = 0x14;
/// EXTI line of the detector.
const LINE: u32 = 1 << 16;
/// Falling thresholds by PLS, mV [ds12288, "PVD thresholds"]. 7 is an external input.
const LEVELS: [u32; 7] = [2000, 2200, 2400, 2500, 2600, 2800, 2900];
/// Supply below which the chip is held in reset by BOR_LEV, mV [ds12288, "Embedded reset and power control block
/// characteristics"]. The first is the factory setting.
const RESET_MV: [u32; 5] = [1700, 2000, 2200, 2500, 2800];

#[derive(Debug)]
pub(crate) struct Supply {
    millivolt: u32,
    /// Supply below which the chip is held in reset, mV.
    reset_mv: u32,
    /// Last value of [`Self::low`].
    was_low: bool,
    pwr: [u32; 40],
    exti: [u32; 16],
}

impl Supply {
    pub fn new() -> Self {
        let (mut pwr, mut exti) = ([0; 40], [0; 16]);
        // range 1; the internal wake-up line
        for (register, value) in [(PWR_CR1, 0x200), (PWR_CR3, 0x8000), (PWR_CR5, CR5_R1MODE)] {
            pwr[register as usize / 4] = value;
        }
        // the lines that have no edges
        for (register, value) in [(EXTI_IMR1, 0xff82_0000), (EXTI_IMR2, 0xffff_ff87)] {
            exti[register as usize / 4] = value;
        }
        Self { millivolt: 3300, reset_mv: RESET_MV[0], was_low: false, pwr, exti }
    }

    /// VDD, which is the reference of the converters too, mV.
    pub fn millivolt(&self) -> u32 {
        self.millivolt
    }

    /// Sets VDD. True if it is too low for the chip.
    pub fn set(&mut self, millivolt: u32) -> bool {
        self.millivolt = millivolt;
        self.look();
        millivolt < self.reset_mv
    }

    /// Sets the level of the option byte.
    pub fn set_brown_out_level(&mut self, level: u32) {
        self.reset_mv = RESET_MV.get(level as usize).copied().unwrap_or(RESET_MV[0]);
    }

    /// Resets the registers. The supply remains.
    pub fn reset(&mut self) {
        *self = Self { millivolt: self.millivolt, reset_mv: self.reset_mv, ..Self::new() };
    }

    /// Whether range 1 is boosted, which allows more than 150 MHz [rm0440, 6.1.5].
    pub fn boosted(&self) -> bool {
        self.pwr[PWR_CR5 as usize / 4] & CR5_R1MODE == 0
    }

    fn low(&self) -> bool {
        let cr2 = self.pwr[PWR_CR2 as usize / 4];
        let level = LEVELS.get((cr2 >> 1 & 7) as usize).copied().unwrap_or(0);
        cr2 & 1 != 0 && self.millivolt < level
    }

    /// Edges of the detector's output become pending on the line.
    fn look(&mut self) {
        let low = self.low();
        let edge = if low { EXTI_RTSR1 } else { EXTI_FTSR1 };
        if low != self.was_low && self.exti[edge as usize / 4] & LINE != 0 {
            self.exti[EXTI_PR1 as usize / 4] |= LINE;
        }
        self.was_low = low;
    }

    pub fn read_pwr(&self, offset: u32) -> u32 {
        let value = self.pwr.get(offset as usize / 4).copied().unwrap_or(0);
        if offset == PWR_SR2 { value & !(1 << 11) | u32::from(self.low()) << 11 } else { value }
    }

    pub fn write_pwr(&mut self, offset: u32, value: u32) {
        if let Some(register) = self.pwr.get_mut(offset as usize / 4) {
            *register = value;
        }
        self.look();
    }

    pub fn read_exti(&self, offset: u32) -> u32 {
        self.exti.get(offset as usize / 4).copied().unwrap_or(0)
    }

    pub fn write_exti(&mut self, offset: u32, value: u32) {
        if let Some(register) = self.exti.get_mut(offset as usize / 4) {
            // pending bits are cleared by writing 1
            *register = if offset == EXTI_PR1 { *register & !value } else { value };
        }
    }

    pub fn interrupt(&self) -> bool {
        self.exti[EXTI_PR1 as usize / 4] & self.exti[EXTI_IMR1 as usize / 4] & LINE != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_detector_interrupts_on_selected_edges() {
        let mut supply = Supply::new();
        supply.write_exti(EXTI_RTSR1, LINE);
        supply.write_exti(EXTI_IMR1, LINE);
        assert!(!supply.set(2500) && !supply.interrupt(), "not enabled");
        supply.set(3300);
        supply.write_pwr(PWR_CR2, 6 << 1 | 1);
        assert!(!supply.set(2950) && !supply.interrupt());
        assert!(!supply.set(2850) && supply.interrupt());
        assert_eq!(supply.read_pwr(PWR_SR2), 1 << 11);
        supply.write_exti(EXTI_PR1, LINE);
        assert!(!supply.interrupt());
        supply.set(3300);
        assert!(!supply.interrupt(), "the falling edge was not asked for");
        assert!(supply.set(1600));
    }
}
