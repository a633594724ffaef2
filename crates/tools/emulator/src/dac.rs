//! DAC1 channel 1: holding register, trigger, output.

const CR: u32 = 0x00;
const SWTRGR: u32 = 0x04;
const DHR12R1: u32 = 0x08;
const DHR12L1: u32 = 0x0c;
const DHR8R1: u32 = 0x10;
const DOR1: u32 = 0x2c;
const MCR: u32 = 0x3c;
const SHHR: u32 = 0x48;
const SHRR: u32 = 0x4c;

/// 0.2 V of 3.3 V.
const RAIL_CODES: f64 = 248.0;

/// TSEL of each timer's trigger output [rm0440, "DAC1 interconnection"]: (code, timer).
pub(crate) const TRIGGERS: [(u32, u8); 7] = [(1, 8), (2, 7), (3, 15), (4, 2), (5, 4), (7, 6), (8, 3)];

#[derive(Debug)]
pub(crate) struct Dac {
    cr: u32,
    other: [u32; 20],
    held: u16,
    output: u16,
    /// Whether the holding register was written since the last transfer.
    pub fresh: bool,
}

impl Dac {
    pub fn new() -> Self {
        let mut other = [0; 20];
        for times in [SHHR, SHRR] {
            other[times as usize / 4] = 0x0001_0001;
        }
        Self { cr: 0, other, held: 0, output: 0, fresh: false }
    }

    /// Output code, `None` while the channel is off.
    pub fn code(&self) -> Option<u16> {
        (self.cr & 1 != 0).then_some(self.output)
    }

    /// Voltage at the pin with a supply of so many mV, as a code at 3.3 V. The buffer, unless it is off, does not come nearer to
    /// the rails than 0.2 V [ds12288, "DAC characteristics"].
    pub fn output_code(&self, millivolt: u32) -> Option<f64> {
        let buffered = matches!(self.read(MCR) & 7, 0 | 1);
        let supply = f64::from(millivolt) / 3300.0;
        self.code().map(|code| {
            let code = f64::from(code) * supply;
            if buffered { code.clamp(RAIL_CODES, 4096.0 * supply - RAIL_CODES) } else { code }
        })
    }

    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            CR => self.cr,
            DHR12R1 => u32::from(self.held),
            DHR12L1 => u32::from(self.held) << 4,
            DHR8R1 => u32::from(self.held) >> 4,
            DOR1 => u32::from(self.output),
            _ => self.other.get(offset as usize / 4).copied().unwrap_or(0),
        }
    }

    /// True when a holding register was written.
    pub fn write(&mut self, offset: u32, value: u32) -> bool {
        let held = match offset {
            DHR12R1 => Some(value & 0xfff),
            DHR12L1 => Some(value >> 4 & 0xfff),
            DHR8R1 => Some((value & 0xff) << 4),
            _ => None,
        };
        match (offset, held) {
            (_, Some(code)) => {
                self.held = code as u16;
                self.fresh = true;
            }
            (CR, _) => self.cr = value,
            (SWTRGR, _) if value & 1 != 0 && self.cr & 2 != 0 => self.transfer(),
            (_, None) => {
                if let Some(register) = self.other.get_mut(offset as usize / 4) {
                    *register = value;
                }
            }
        }
        if self.cr & 3 == 1 {
            self.transfer();
        }
        held.is_some()
    }

    /// A timer's trigger output. True when it transferred the holding register.
    pub fn trigger(&mut self, timer: u8) -> bool {
        let selected = TRIGGERS.iter().any(|&(code, t)| t == timer && code == self.cr >> 2 & 0xf);
        let listens = self.cr & 3 == 3 && selected;
        if listens {
            self.transfer();
        }
        listens
    }

    fn transfer(&mut self) {
        self.output = self.held;
        self.fresh = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_buffer_ends_before_the_rails() {
        let mut dac = Dac::new();
        dac.write(CR, 1);
        for (code, buffered) in [(0, 248.0), (100, 248.0), (2048, 2048.0), (4095, 3848.0)] {
            dac.write(DHR12R1, code);
            dac.write(MCR, 0);
            assert_eq!(dac.output_code(3300), Some(buffered));
            dac.write(MCR, 2);
            assert_eq!(dac.output_code(3300), Some(f64::from(code)));
        }
        // 1.5 V of 3.0 V
        dac.write(DHR12R1, 2048);
        assert!((dac.output_code(3000).expect("on") * 3.3 / 4096.0 - 1.5).abs() < 1e-9);
    }

    #[test]
    fn alignment_and_trigger_are_decoded() {
        let mut dac = Dac::new();
        assert_eq!(dac.code(), None);
        dac.write(CR, 1);
        dac.write(DHR12R1, 2048);
        assert_eq!(dac.code(), Some(2048));
        dac.write(DHR12L1, 2048);
        assert_eq!(dac.code(), Some(128), "a right-aligned code in the left-aligned register");
        dac.write(CR, 3 | 2 << 2);
        dac.write(DHR12R1, 3000);
        assert!(!dac.trigger(6));
        assert_eq!(dac.code(), Some(128));
        assert!(dac.trigger(7));
        assert_eq!(dac.code(), Some(3000));
    }
}
