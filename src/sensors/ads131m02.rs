//! TI ADS131M02: two 24-bit converters on SPI in mode 1. A load cell is on channel 0; channel 1 is off.
//!
//! One frame of 12 bytes, words of 24 bits [ads131m02, ch. 8.5.1]:
//!
//! ```text
//! to the chip    00 00 00  00 00 00  00 00 00  00 00 00    command NULL
//! from the chip  ss ss 00  aa aa aa  bb bb bb  cc cc 00    status, channels 0 and 1, CRC-16 of the nine bytes before
//! ```
//!
//! | on the line | seen by |
//! | --- | --- |
//! | flipped bits | CRC-16 CCITT from 0xffff: every burst of up to 16 bits |
//! | nothing connected, or a line at ground: ones, zeros | a wrong CRC |
//! | a converter that restarted, and so lost its gain | status |
//! | a converter without its clock | [`STALE`] frames without a new value |

use embedded_hal::spi::{MODE_1, Mode, SpiDevice};

/// Mode of the bus.
pub const MODE_OF_BUS: Mode = MODE_1;
/// A frame.
pub type Frame = [u8; 12];
/// The frame that reads a value.
pub const READ: Frame = [0; 12];
/// Frames in a row without a new value that are a converter without its clock.
pub const STALE: u8 = 3;

/// Registers and their content: no reset flag, words of 24 bits, time-out of frames; channel 0 with 32 000 values a second, high
/// resolution; gain 128, which makes 9.4 mV the full scale [ads131m02, ch. 8.6].
const SETTINGS: [(u8, u16); 3] = [(MODE, 0x0110), (CLOCK, 0x0102), (GAIN, 0x0007)];
const MODE: u8 = 2;
const CLOCK: u8 = 3;
const GAIN: u8 = 4;
const WRITE: u16 = 0x6000;
const READ_REGISTER: u16 = 0xa000;
/// Status of a converter with these settings: words of 24 bits, and no flag.
const STATUS: u16 = 0x0100;
const FLAGS: u16 = 0xff00;
/// A new value of channel 0.
const READY: u16 = 1;

/// Reason why a frame gives no value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoValue {
    /// The bus transferred nothing.
    Bus,
    /// Flipped bits, or no converter.
    Crc,
    /// The converter restarted, or has other settings.
    Status,
    /// No new value for too long.
    Stale,
}

/// Writes the settings and reads them back. The bus must transfer while it is called.
///
/// # Errors
/// The converter does not answer as it should.
pub fn configure(spi: &mut impl SpiDevice) -> Result<(), NoValue> {
    for (register, content) in SETTINGS {
        let register = u16::from(register) << 7;
        exchange(spi, [WRITE | register, content])?;
        // the answer to a command comes with the next frame
        exchange(spi, [READ_REGISTER | register, 0])?;
        let answer = exchange(spi, [0; 2])?;
        if answer != content {
            return Err(NoValue::Status);
        }
    }
    Ok(())
}

/// One frame with these two words. The word that the chip answers first, to the frame before.
fn exchange(spi: &mut impl SpiDevice, words: [u16; 2]) -> Result<u16, NoValue> {
    let mut frame = READ;
    for (to, word) in frame.chunks_exact_mut(3).zip(words) {
        let [high, low] = word.to_be_bytes();
        (to[0], to[1]) = (high, low);
    }
    spi.transfer_in_place(&mut frame).map_err(|_| NoValue::Bus)?;
    if is_intact(&frame) { Ok(u16::from_be_bytes([frame[0], frame[1]])) } else { Err(NoValue::Crc) }
}

/// The converter on its bus, with its settings.
#[derive(Debug)]
pub struct Ads131m02<SPI> {
    spi: SPI,
    value: i32,
    /// Frames in a row without a new value.
    stale: u8,
}

impl<SPI: SpiDevice> Ads131m02<SPI> {
    /// A converter on a bus in [`MODE_OF_BUS`], at most 25 MHz, that was configured.
    pub const fn new(spi: SPI) -> Self {
        Self { spi, value: 0, stale: 0 }
    }

    /// Reads channel 0: the newest value, −2²³ … 2²³ − 1, 9.4 mV at 2²³.
    ///
    /// # Errors
    /// A frame that cannot be trusted.
    #[inline(always)] // in the control step
    pub fn read(&mut self) -> Result<i32, NoValue> {
        let mut frame = READ;
        if self.spi.transfer_in_place(&mut frame).is_err() {
            return Err(NoValue::Bus);
        }
        if !is_intact(&frame) {
            return Err(NoValue::Crc);
        }
        let status = u16::from_be_bytes([frame[0], frame[1]]);
        if status & FLAGS != STATUS {
            return Err(NoValue::Status);
        }
        if status & READY != 0 {
            self.stale = 0;
            // the sign is in the upper byte of the word
            self.value = i32::from_be_bytes([frame[3], frame[4], frame[5], 0]) >> 8;
        } else {
            self.stale = self.stale.saturating_add(1);
        }
        if self.stale >= STALE { Err(NoValue::Stale) } else { Ok(self.value) }
    }
}

/// Whether a frame has the CRC of its bytes.
#[inline(always)]
fn is_intact(frame: &Frame) -> bool {
    let [bytes @ .., high, low, _] = frame;
    crc16(bytes) == u32::from(*high) << 8 | u32::from(*low)
}

/// CRC-16 CCITT from 0xffff. Once in the memory of the control step, which is nearly full.
#[inline(never)]
fn crc16(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0xffff, |crc, byte| next(crc, *byte))
}

/// CRC-16 CCITT with another byte: no table, which would be a load from flash.
#[inline(always)]
const fn next(crc: u32, byte: u8) -> u32 {
    let above = crc >> 8 ^ byte as u32;
    let above = above ^ above >> 4;
    (crc << 8 ^ above << 12 ^ above << 5 ^ above) & 0xffff
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    /// CRC-16 CCITT, bit by bit.
    fn bitwise(bytes: &[u8]) -> u16 {
        bytes.iter().fold(0xffff, |crc, byte| {
            (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| {
                if crc & 0x8000 != 0 { crc << 1 ^ 0x1021 } else { crc << 1 }
            })
        })
    }

    /// An answer of the chip.
    fn frame(first: u16, value: i32) -> Frame {
        let mut frame = READ;
        frame[..2].copy_from_slice(&first.to_be_bytes());
        frame[3..6].copy_from_slice(&(value << 8).to_be_bytes()[..3]);
        let crc = bitwise(&frame[..9]);
        frame[9..11].copy_from_slice(&crc.to_be_bytes());
        frame
    }

    fn transfers(pairs: &[(Frame, Frame)]) -> Vec<Transaction<u8>> {
        let transfer = |(sent, answer): &(Frame, Frame)| {
            [
                Transaction::transaction_start(),
                Transaction::transfer_in_place(sent.to_vec(), answer.to_vec()),
                Transaction::transaction_end(),
            ]
        };
        pairs.iter().flat_map(transfer).collect()
    }

    fn read<const N: usize>(answers: [Frame; N]) -> [Result<i32, NoValue>; N] {
        let mut spi = Mock::new(&transfers(&answers.map(|answer| (READ, answer))));
        let mut converter = Ads131m02::new(spi.clone());
        let values = core::array::from_fn(|_| converter.read());
        spi.done();
        values
    }

    #[test]
    fn the_crc_is_that_of_its_bits() {
        // check value of CRC-16 with this polynomial, from 0xffff
        assert_eq!(bitwise(b"123456789"), 0x29b1);
        assert_eq!(crc16(b"123456789"), 0x29b1);
    }

    #[test]
    fn values_have_their_sign() {
        for value in [0, 1, -1, 0x7f_ffff, -0x80_0000, 0x12_3456, -0x12_3456] {
            assert_eq!(read([frame(STATUS | READY, value)]), [Ok(value)]);
        }
    }

    #[test]
    fn every_flipped_bit_is_seen() {
        for bit in 0..88 {
            let mut bad = frame(STATUS | READY, 0x0a_bcde);
            bad[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(read([bad]), [Err(NoValue::Crc)], "bit {bit}");
        }
    }

    #[test]
    fn a_missing_converter_is_seen_at_once() {
        assert_eq!(read([[0xff; 12], [0; 12]]), [Err(NoValue::Crc), Err(NoValue::Crc)]);
    }

    #[test]
    fn a_restart_is_seen() {
        // the reset value of its status: the flag RESET
        assert_eq!(read([frame(0x0501, 7)]), [Err(NoValue::Status)]);
    }

    #[test]
    fn a_stopped_clock_is_seen_in_three_frames() {
        let (new, old) = (frame(STATUS | READY, 5), frame(STATUS, 6));
        assert_eq!(read([new, old, old, old, new])[1..], [Ok(5), Ok(5), Err(NoValue::Stale), Ok(5)]);
    }

    #[test]
    fn settings_are_written_and_read_back() {
        let word = |first: u16, second: u16| {
            let mut frame = READ;
            frame[..2].copy_from_slice(&first.to_be_bytes());
            frame[3..5].copy_from_slice(&second.to_be_bytes());
            frame
        };
        let any = frame(0x0500, 0);
        let expected: Vec<_> = [(0x6100, 0xa100, 0x0110), (0x6180, 0xa180, 0x0102), (0x6200, 0xa200, 0x0007)]
            .into_iter()
            .flat_map(|(write, ask, content)| {
                [(word(write, content), any), (word(ask, 0), any), (READ, frame(content, 0))]
            })
            .collect();
        let mut spi = Mock::new(&transfers(&expected));
        assert_eq!(configure(&mut spi), Ok(()));
        spi.done();
        let mut deaf = Mock::new(&transfers(&[expected[0], expected[1], (READ, frame(0x0510, 0))]));
        assert_eq!(configure(&mut deaf), Err(NoValue::Status));
        deaf.done();
    }
}
