//! MagnTek MT6835: absolute magnetic encoder, 21 bits a turn, on SPI in mode 3.
//!
//! One frame of 6 bytes reads it [mt6835, ch. 7.6]:
//!
//! ```text
//! to the chip    a0 03  -- -- -- --        burst read of the angle, from register 3 on
//! from the chip  -- --  aa aa as cc        angle (21 bits), status (3 bits), CRC-8 of the 24 bits
//! ```
//!
//! | on the line | seen by |
//! | --- | --- |
//! | flipped bits | CRC-8, x⁸ + x² + x + 1: every burst of up to 8 bits, and 255 of 256 others |
//! | nothing connected, MISO pulled up: ones | a wrong CRC |
//! | MISO at ground: zeros, whose CRC is right | [`ZEROS`] such frames in a row |
//! | magnet lost, supply too low, too fast | status |

use embedded_hal::spi::{MODE_3, Mode, SpiDevice};

/// Mode of the bus.
pub const MODE: Mode = MODE_3;
/// Bits of an angle.
pub const BITS: u32 = 21;
/// The frame that reads the angle.
pub const READ_ANGLE: [u8; 6] = [0xa0, 0x03, 0, 0, 0, 0];
/// Frames of zeros in a row that are a line at ground. A handle that rests at angle 0 gives some: its noise is several steps.
pub const ZEROS: u8 = 16;

const TOO_FAST: u32 = 1;
const WEAK_FIELD: u32 = 2;
const LOW_SUPPLY: u32 = 4;

/// Reason why a frame gives no angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoAngle {
    /// The bus transferred nothing.
    Bus,
    /// All ones or all zeros: no chip.
    Absent,
    /// Flipped bits.
    Crc,
    /// The magnet is too far, or lost.
    WeakField,
    /// Supply of the chip below its minimum.
    LowSupply,
    /// Faster than the chip follows.
    TooFast,
}

/// The encoder on its bus.
#[derive(Debug)]
pub struct Mt6835<SPI> {
    spi: SPI,
    /// Frames of zeros in a row.
    zeros: u8,
}

impl<SPI: SpiDevice> Mt6835<SPI> {
    /// An encoder on a bus in [`MODE`], at most 16 MHz.
    pub const fn new(spi: SPI) -> Self {
        Self { spi, zeros: 0 }
    }

    /// Reads the angle, 0 … 2²¹ − 1.
    ///
    /// # Errors
    /// A frame that cannot be trusted.
    #[inline(always)] // in the control step
    pub fn read(&mut self) -> Result<u32, NoAngle> {
        let mut frame = READ_ANGLE;
        if self.spi.transfer_in_place(&mut frame).is_err() {
            return Err(NoAngle::Bus);
        }
        let [_, _, high, middle, low, crc] = frame.map(u32::from);
        let word = high << 16 | middle << 8 | low;
        if word | crc == 0 {
            self.zeros = self.zeros.saturating_add(1);
            return if self.zeros >= ZEROS { Err(NoAngle::Absent) } else { Ok(0) };
        }
        self.zeros = 0;
        if crc8(word) != crc {
            Err(if word == 0xff_ffff && crc == 0xff { NoAngle::Absent } else { NoAngle::Crc })
        } else if word & WEAK_FIELD != 0 {
            Err(NoAngle::WeakField)
        } else if word & LOW_SUPPLY != 0 {
            Err(NoAngle::LowSupply)
        } else if word & TOO_FAST != 0 {
            Err(NoAngle::TooFast)
        } else {
            Ok(word >> 3)
        }
    }

    /// The bus.
    pub const fn bus(&mut self) -> &mut SPI {
        &mut self.spi
    }
}

/// CRC-8 of 24 bits, with x⁸ + x² + x + 1 from 0.
#[inline(always)]
fn crc8(word: u32) -> u32 {
    let first = times_x8(word >> 16 & 0xff);
    let second = times_x8(first ^ (word >> 8 & 0xff));
    times_x8(second ^ (word & 0xff))
}

/// Product with x⁸, which is x² + x + 1: no table, which would be a load from flash.
#[inline(always)]
const fn times_x8(byte: u32) -> u32 {
    let product = byte ^ byte << 1 ^ byte << 2;
    let above = product >> 8;
    (product ^ above ^ above << 1 ^ above << 2) & 0xff
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::spi::{ErrorKind, ErrorType, Operation};
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    /// The CRC as the data sheet describes it, bit by bit.
    fn bitwise(bytes: &[u8]) -> u8 {
        bytes.iter().fold(0, |crc, byte| {
            (0..8).fold(crc ^ byte, |crc, _| if crc & 0x80 != 0 { crc << 1 ^ 0x07 } else { crc << 1 })
        })
    }

    /// A frame of an angle with its status.
    fn frame(angle: u32, status: u32) -> [u8; 6] {
        let [_, high, middle, low] = (angle << 3 | status).to_be_bytes();
        [0, 0, high, middle, low, bitwise(&[high, middle, low])]
    }

    /// Results of reading these frames one after the other.
    fn read<const N: usize>(frames: [[u8; 6]; N]) -> [Result<u32, NoAngle>; N] {
        let expected: Vec<_> = frames
            .iter()
            .flat_map(|answer| {
                [
                    Transaction::transaction_start(),
                    Transaction::transfer_in_place(READ_ANGLE.to_vec(), answer.to_vec()),
                    Transaction::transaction_end(),
                ]
            })
            .collect();
        let mut encoder = Mt6835::new(Mock::new(&expected));
        let angles = core::array::from_fn(|_| encoder.read());
        encoder.bus().done();
        angles
    }

    #[test]
    fn the_crc_is_that_of_its_bits() {
        // check value of CRC-8 with this polynomial, from 0
        assert_eq!(bitwise(b"123456789"), 0xf4);
        for word in (0..1 << 24).step_by(97) {
            let [_, bytes @ ..] = u32::to_be_bytes(word);
            assert_eq!(crc8(word), u32::from(bitwise(&bytes)), "{word:#x}");
        }
    }

    #[test]
    fn angles_are_read_whole() {
        for angle in [0, 1, 0x10_0000, 0x15_5555, 0x1f_ffff] {
            assert_eq!(read([frame(angle, 0)]), [Ok(angle)]);
        }
        // what the line has during the command does not matter
        let mut noisy = frame(0x1234, 0);
        noisy[..2].copy_from_slice(&[0xff, 0x5a]);
        assert_eq!(read([noisy]), [Ok(0x1234)]);
    }

    #[test]
    fn every_flipped_bit_is_seen() {
        for angle in [1, 0x0a_bcde, 0x1f_ffff] {
            for bit in 0..32 {
                let mut bad = frame(angle, 0);
                bad[2 + bit / 8] ^= 1 << (bit % 8);
                assert_eq!(read([bad]), [Err(NoAngle::Crc)], "bit {bit} of {angle:#x}");
            }
        }
    }

    #[test]
    fn a_lost_magnet_and_a_low_supply_are_seen() {
        assert_eq!(read([frame(5, WEAK_FIELD)]), [Err(NoAngle::WeakField)]);
        assert_eq!(read([frame(5, LOW_SUPPLY)]), [Err(NoAngle::LowSupply)]);
        assert_eq!(read([frame(5, TOO_FAST)]), [Err(NoAngle::TooFast)]);
    }

    #[test]
    fn an_open_line_is_seen_at_once() {
        assert_eq!(read([[0xff; 6]]), [Err(NoAngle::Absent)]);
    }

    #[test]
    fn a_line_at_ground_is_seen_in_16_frames() {
        let angles = read([[0; 6]; ZEROS as usize + 1]);
        assert_eq!(angles[14..], [Ok(0), Err(NoAngle::Absent), Err(NoAngle::Absent)]);
        // angle 0 is an angle
        let angles = read([[0; 6], frame(1, 0), [0; 6]]);
        assert_eq!(angles, [Ok(0), Ok(1), Ok(0)]);
    }

    /// A bus that transfers nothing.
    struct Broken;

    impl ErrorType for Broken {
        type Error = ErrorKind;
    }

    impl SpiDevice for Broken {
        fn transaction(&mut self, _: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
            Err(ErrorKind::Other)
        }
    }

    #[test]
    fn a_bus_that_fails_is_no_angle() {
        assert_eq!(Mt6835::new(Broken).read(), Err(NoAngle::Bus));
    }
}
