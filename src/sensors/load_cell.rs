//! A load cell on a 24-bit converter, in the codes of the board's own converter.

use super::ads131m02::Ads131m02;
use embedded_hal::spi::SpiDevice;
use haptics::{FaultKind, Inputs, NOMINAL_SUPPLY};

/// Code of no force at [`NOMINAL_SUPPLY`]: half of the scale.
const MIDDLE: f32 = 32_768.0;
/// Values of the converter in such a code: the upper 16 bits are used.
const VALUES: f32 = 256.0;

const TOP: u32 = Inputs::TOP_CODE as u32;

/// The load cell.
#[derive(Debug)]
pub struct LoadCell<SPI> {
    converter: Ads131m02<SPI>,
    /// Code of value 0, and a half to round; codes in a value. Codes of the board's converter follow its supply, by which the device
    /// converts them; the reference of this one is its own.
    zero: f32,
    per_value: f32,
    code: u16,
    trouble: Option<FaultKind>,
}

impl<SPI: SpiDevice> LoadCell<SPI> {
    /// A load cell on this bus, whose converter was configured, of a device with this supply, V.
    pub fn new(spi: SPI, supply: f32) -> Self {
        let ratio = NOMINAL_SUPPLY / supply;
        let (zero, per_value) = (MIDDLE * ratio + 0.5, ratio / VALUES);
        Self { converter: Ads131m02::new(spi), zero, per_value, code: zero as u16, trouble: None }
    }

    /// One sample. A frame that cannot be trusted leaves the last code, and is a fault.
    #[inline(always)]
    pub fn sample(&mut self) -> u16 {
        match self.converter.read() {
            Ok(value) => {
                // `as` saturates
                self.code = ((value as f32 * self.per_value + self.zero) as u32).min(TOP) as u16;
                self.trouble = None;
            }
            Err(_) => self.trouble = Some(FaultKind::SensorDead),
        }
        self.code
    }

    /// Fault of the last sample.
    #[inline(always)]
    pub const fn trouble(&self) -> Option<FaultKind> {
        self.trouble
    }
}

#[cfg(test)]
mod tests {
    use super::super::ads131m02::{Frame, READ};
    use super::*;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    /// Answers of the chip with this value, by their CRC.
    const ZERO: Frame = [0x01, 0x01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];

    fn frame(value: i32) -> Frame {
        let mut frame = ZERO;
        frame[3..6].copy_from_slice(&(value << 8).to_be_bytes()[..3]);
        let crc = frame[..9].iter().fold(0xffff_u16, |crc, byte| {
            (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| {
                if crc & 0x8000 != 0 { crc << 1 ^ 0x1021 } else { crc << 1 }
            })
        });
        frame[9..11].copy_from_slice(&crc.to_be_bytes());
        frame
    }

    fn codes<const N: usize>(supply: f32, answers: [Frame; N]) -> [(u16, Option<FaultKind>); N] {
        let transfers: Vec<_> = answers
            .iter()
            .flat_map(|answer| {
                [
                    Transaction::transaction_start(),
                    Transaction::transfer_in_place(READ.to_vec(), answer.to_vec()),
                    Transaction::transaction_end(),
                ]
            })
            .collect();
        let mut spi = Mock::new(&transfers);
        let mut cell = LoadCell::new(spi.clone(), supply);
        let codes = core::array::from_fn(|_| (cell.sample(), cell.trouble()));
        spi.done();
        codes
    }

    #[test]
    fn codes_are_the_upper_bits_about_the_middle() {
        let values = [0, 256, -256, 0x7f_ffff, -0x80_0000].map(frame);
        let all = codes(3.3, values).map(|(code, _)| code);
        assert_eq!(all, [32_768, 32_769, 32_767, Inputs::TOP_CODE, 0]);
    }

    #[test]
    fn a_code_has_the_supply_by_which_the_device_converts_it() {
        // the device takes a code for supply/65 536 V, and 1.65 V for no force
        let volt = |code: u16, supply: f32| f32::from(code) * supply;
        for value in [0, 7_000, -7_000] {
            let [(at_3_0, _)] = codes(3.0, [frame(value * 256)]);
            let [(at_3_3, _)] = codes(3.3, [frame(value * 256)]);
            assert!((volt(at_3_0, 3.0) - volt(at_3_3, 3.3)).abs() < 3.0, "{value}");
        }
    }

    #[test]
    fn a_bad_frame_keeps_the_code_and_is_a_fault() {
        let dead = Some(FaultKind::SensorDead);
        let seen = codes(3.3, [frame(2_560), [0xff; 12], frame(512)]);
        assert_eq!(seen, [(32_778, None), (32_778, dead), (32_770, None)]);
    }
}
