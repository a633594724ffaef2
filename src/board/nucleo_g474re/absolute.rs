//! The absolute encoder on SPI2 of the STM32G474, see [`crate::sensors::mt6835`].

use super::TICK_HZ;
use super::frames::{Frames, Line, Memory};
use crate::board::{Middle, MiddleNews};
use crate::sensors::mt6835::{MODE, READ_ANGLE};
use crate::sensors::{AbsoluteEncoder, COUNTS_PER_TURN, Count, angle_at};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use embassy_stm32::Peri;
use embassy_stm32::gpio::AnyPin;
use embassy_stm32::pac::{self, spi::Spi, spi::vals::Br};
use embassy_stm32::peripherals::SPI2;
use embedded_hal::spi::Mode;
use haptics::{Device, FaultKind};
use link::ORIGIN_KEY;

/// Alternate function of SPI2 on its pins.
const FUNCTION: u8 = 5;
/// Longest time from power-up to a good angle, ms.
const STARTS_MS: u32 = 50;
/// No angle.
const NONE: u32 = u32::MAX;

static MEMORY: Memory<6> = Memory::new();
/// Angle at count 0 since the start, and the one in the flash; [`NONE`] until known.
static ZERO: AtomicU32 = AtomicU32::new(NONE);
static KEPT: AtomicU32 = AtomicU32::new(NONE);

pub struct Spi2;

impl Line<6> for Spi2 {
    type Clock = SPI2;
    const SPI: Spi = pac::SPI2;
    const MODE: Mode = MODE;
    // 5.3 MHz, of the 16 MHz that the chip follows: for a cable
    const RATE: Br = Br::DIV32;
    const CHANNELS: [usize; 3] = [0, 1, 2];
    // TIM6 update, SPI2 receive and transmit
    const REQUESTS: [u8; 3] = [8, 12, 13];

    fn memory() -> &'static Memory<6> {
        &MEMORY
    }
}

/// The position of the handle from the absolute encoder.
pub struct Absolute(AbsoluteEncoder<Frames<Spi2, 6>>);

impl Absolute {
    /// Takes NSS, SCK, MISO and MOSI of SPI2.
    pub fn new(pins: [Peri<'static, AnyPin>; 4]) -> Self {
        Self(AbsoluteEncoder::new(Frames::new(pins, FUNCTION, READ_ANGLE)))
    }

    /// Travel in a count, m: a turn of the encoder is 42.1 mm, more than the stroke of [thesis, table 3-1].
    pub const fn metre_per_count(_: f32) -> f32 {
        42.1e-3 / COUNTS_PER_TURN as f32
    }

    /// Reads an item of the flash.
    pub fn load(key: u8, item: &[u8]) {
        if key == ORIGIN_KEY
            && let Ok(bytes) = <[u8; 4]>::try_from(item)
        {
            KEPT.store(u32::from_le_bytes(bytes), Relaxed);
        }
    }

    /// Begins to count, once the encoder gives an angle. True if the position is from the middle of the stroke.
    pub fn begin(&mut self, device: &Device) -> bool {
        let kept = Some(KEPT.load(Relaxed)).filter(|angle| *angle < COUNTS_PER_TURN);
        let angle = (0..STARTS_MS).find_map(|_| {
            self.0.bus().start();
            cortex_m::asm::delay(TICK_HZ / 1_000);
            self.0.angle().ok()
        });
        // without a stored angle the count begins here
        self.0.count_from(kept.or(angle).unwrap_or(0));
        ZERO.store(self.0.zero(), Relaxed);
        // over more than a turn an angle is two places
        let turn = COUNTS_PER_TURN as f32 * device.metre_per_count;
        kept.is_some() && angle.is_some() && device.stroke < turn
    }

    /// Reads the encoder with every control period.
    pub fn follow() {
        Frames::<Spi2, 6>::follow();
        // last: a reset of the timer clears it
        pac::TIM6.dier().modify(|w| w.set_ude(true));
    }

    /// Time of the sample, count, and time of the count's last change.
    #[inline(always)]
    pub fn sample(&mut self) -> (u32, u32, u32) {
        let ticks = pac::TIM5.cnt().read();
        let Count { count, edge_ticks } = self.0.sample(ticks);
        (ticks, count, edge_ticks)
    }

    /// Fault of the last sample.
    #[inline(always)]
    pub const fn trouble(&self) -> Option<FaultKind> {
        self.0.trouble()
    }

    /// Keeps the angle at the middle of the stroke for the next start.
    pub fn middle(now: Middle) -> MiddleNews {
        let Middle::At(count) = now else { return MiddleNews::None };
        let angle = angle_at(ZERO.load(Relaxed), count);
        if KEPT.swap(angle, Relaxed) == angle {
            MiddleNews::None
        } else {
            MiddleNews::Keep(angle.to_le_bytes())
        }
    }
}
