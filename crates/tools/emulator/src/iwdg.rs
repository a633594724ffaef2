//! The independent watchdog, on its own 32 kHz oscillator.

use crate::UNITS_PER_SECOND;

const LSI_HZ: u64 = 32_000;

#[derive(Debug, Default)]
pub(crate) struct Iwdg {
    unlocked: bool,
    prescaler: u32,
    reload: u32,
    /// Virtual time at which the chip resets, once started.
    pub deadline: Option<u64>,
    /// Number of feedings.
    pub fed: u64,
}

impl Iwdg {
    pub fn new() -> Self {
        Self { reload: 0xfff, ..Self::default() }
    }

    fn timeout(&self) -> u64 {
        let ticks = u64::from(self.reload + 1) * (4 << self.prescaler.min(6));
        ticks * UNITS_PER_SECOND / LSI_HZ
    }

    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            0x04 => self.prescaler,
            0x08 => self.reload,
            0x10 => 0xfff,
            _ => 0,
        }
    }

    pub fn write(&mut self, offset: u32, value: u32, now: u64) {
        match (offset, value & 0xffff) {
            (0x00, 0x5555) => self.unlocked = true,
            (0x00, 0xaaaa) => {
                self.unlocked = false;
                self.fed += 1;
                if self.deadline.is_some() {
                    self.deadline = Some(now + self.timeout());
                }
            }
            (0x00, 0xcccc) => {
                self.unlocked = false;
                self.deadline = Some(now + self.timeout());
            }
            (0x04, v) if self.unlocked => self.prescaler = v & 7,
            (0x08, v) if self.unlocked => self.reload = v & 0xfff,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_out_unless_fed_and_settings_need_the_key() {
        let mut iwdg = Iwdg::new();
        iwdg.write(8, 31, 0);
        assert_eq!(iwdg.read(8), 0xfff, "written without the key");
        iwdg.write(0, 0x5555, 0);
        iwdg.write(8, 31, 0);
        iwdg.write(4, 0, 0);
        iwdg.write(0, 0xcccc, 0);
        // 32 ticks of 8 kHz
        assert_eq!(iwdg.deadline, Some(UNITS_PER_SECOND * 4 / 1000));
        iwdg.write(0, 0xaaaa, 1000);
        assert_eq!(iwdg.deadline, Some(1000 + UNITS_PER_SECOND * 4 / 1000));
    }
}
