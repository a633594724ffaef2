//! An absolute encoder as the position of the handle: a count that knows the middle of the stroke after one calibration.
//!
//! The handle drives the encoder over less than a turn, as by a pinion or a capstan. The angle of the middle of the stroke is
//! stored once; from then on each start knows the position.
//!
//! An angle that cannot be trusted is a fault of the encoder, in the same period. The count stays; the next good angle
//! continues it.

use super::mt6835::{BITS, Mt6835, NoAngle};
use embedded_hal::spi::SpiDevice;
use haptics::FaultKind;

/// Counts that the control step sees in a turn. The finest with which the overspeed of the default device has at most 1e6 counts
/// a second.
pub const COUNTS_PER_TURN: u32 = 1 << COUNT_BITS;
const COUNT_BITS: u32 = 15;

/// A sample of the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Count {
    /// Count. Wraps.
    pub count: u32,
    /// Time of the sample that saw the count change last, ticks.
    pub edge_ticks: u32,
}

/// The encoder of the handle.
#[derive(Debug)]
pub struct AbsoluteEncoder<SPI> {
    chip: Mt6835<SPI>,
    /// Angle at count 0, and the last angle, in counts.
    zero: u32,
    angle: u32,
    last: Count,
    trouble: Option<FaultKind>,
}

impl<SPI: SpiDevice> AbsoluteEncoder<SPI> {
    /// An encoder on this bus, which has not been read.
    pub const fn new(spi: SPI) -> Self {
        let last = Count { count: 0, edge_ticks: 0 };
        Self { chip: Mt6835::new(spi), zero: 0, angle: 0, last, trouble: None }
    }

    /// The bus.
    pub const fn bus(&mut self) -> &mut SPI {
        self.chip.bus()
    }

    /// The angle now, in counts.
    ///
    /// # Errors
    /// A frame that cannot be trusted.
    #[inline(always)] // in the control step
    pub fn angle(&mut self) -> Result<u32, NoAngle> {
        self.chip.read().map(counts)
    }

    /// Count 0 is at this angle from now on.
    pub const fn count_from(&mut self, zero: u32) {
        let zero = zero % COUNTS_PER_TURN;
        (self.zero, self.angle, self.last.count) = (zero, zero, 0);
    }

    /// Angle at count 0.
    #[must_use]
    pub const fn zero(&self) -> u32 {
        self.zero
    }

    /// One sample, at this time.
    #[inline(always)]
    pub fn sample(&mut self, ticks: u32) -> Count {
        match self.angle() {
            Ok(angle) => {
                let moved = shortest(angle.wrapping_sub(self.angle));
                self.angle = angle;
                self.trouble = None;
                if moved != 0 {
                    let count = self.last.count.wrapping_add(moved as u32);
                    self.last = Count { count, edge_ticks: ticks };
                }
            }
            Err(why) => self.trouble = Some(fault(why)),
        }
        self.last
    }

    /// Fault of the last sample.
    #[inline(always)]
    pub const fn trouble(&self) -> Option<FaultKind> {
        self.trouble
    }
}

/// Angle at a count, when count 0 is at the angle `zero`.
#[must_use]
pub const fn angle_at(zero: u32, count: u32) -> u32 {
    zero.wrapping_add(count) % COUNTS_PER_TURN
}

#[inline(always)]
const fn counts(angle: u32) -> u32 {
    angle >> (BITS - COUNT_BITS)
}

/// A difference of angles as the shorter way round, counts.
#[inline(always)]
const fn shortest(difference: u32) -> i32 {
    (difference << (32 - COUNT_BITS)) as i32 >> (32 - COUNT_BITS)
}

/// Fault that a person is told.
#[inline(always)]
const fn fault(why: NoAngle) -> FaultKind {
    match why {
        // cable and supply
        NoAngle::Bus | NoAngle::Absent | NoAngle::WeakField | NoAngle::LowSupply => FaultKind::EncoderSilent,
        // cable and shield
        NoAngle::Crc | NoAngle::TooFast => FaultKind::EncoderJump,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::convert::Infallible;
    use embedded_hal::spi::{ErrorType, Operation};

    /// A bus that answers with these frames.
    struct Answers(Vec<[u8; 4]>);

    impl ErrorType for Answers {
        type Error = Infallible;
    }

    impl SpiDevice for Answers {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
            let [Operation::TransferInPlace(frame)] = operations else { panic!("{operations:?}") };
            frame[2..].copy_from_slice(&self.0.remove(0));
            Ok(())
        }
    }

    /// Frame of an angle in counts.
    fn frame(angle: u32) -> [u8; 4] {
        let [_, high, middle, low] = (angle << (BITS - COUNT_BITS + 3)).to_be_bytes();
        let crc = [high, middle, low].iter().fold(0_u8, |crc, byte| {
            (0..8).fold(crc ^ byte, |crc, _| if crc & 0x80 != 0 { crc << 1 ^ 7 } else { crc << 1 })
        });
        [high, middle, low, crc]
    }

    #[test]
    fn the_count_begins_at_the_distance_from_the_stored_angle() {
        for (zero, angle, count) in
            [(100, 300, 200), (300, 100, -200), (100, COUNTS_PER_TURN - 100, -200), (32_000, 232, 1_000)]
        {
            let mut encoder = AbsoluteEncoder::new(Answers(vec![frame(angle)]));
            encoder.count_from(zero);
            assert_eq!(encoder.sample(7), Count { count: count as u32, edge_ticks: 7 });
            assert_eq!(angle_at(encoder.zero(), count as u32), angle);
        }
    }

    #[test]
    fn the_count_goes_on_over_the_end_of_the_turn() {
        let angles = [0, 10_000, 20_000, 30_000, 7_232, 30_000];
        let mut encoder = AbsoluteEncoder::new(Answers(angles.map(frame).to_vec()));
        let counts = angles.map(|_| encoder.sample(1).count);
        assert_eq!(counts, [0, 10_000, 20_000, 30_000, 40_000, 30_000]);
    }

    #[test]
    fn the_time_is_that_of_the_last_change() {
        let mut encoder = AbsoluteEncoder::new(Answers([5, 5, 6].map(frame).to_vec()));
        let edges = [10, 20, 30].map(|ticks| encoder.sample(ticks).edge_ticks);
        assert_eq!(edges, [10, 10, 30]);
    }

    #[test]
    fn a_bad_frame_is_a_fault_and_moves_nothing() {
        let mut flipped = frame(500);
        flipped[0] ^= 4;
        let mut encoder = AbsoluteEncoder::new(Answers(vec![frame(100), flipped, [0xff; 4], frame(500)]));
        let seen = [(); 4].map(|()| (encoder.sample(1).count, encoder.trouble()));
        assert_eq!(
            seen,
            [
                (100, None),
                (100, Some(FaultKind::EncoderJump)),
                (100, Some(FaultKind::EncoderSilent)),
                (500, None)
            ]
        );
    }
}
