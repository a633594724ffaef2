//! The load cell on SPI3 of the STM32G474, see [`crate::sensors::ads131m02`].

use super::TICK_HZ;
use super::frames::{Frames, Line, Memory, Unfinished};
use crate::sensors::LoadCell;
use crate::sensors::ads131m02::{MODE_OF_BUS, READ, configure};
use embassy_stm32::Peri;
use embassy_stm32::gpio::AnyPin;
use embassy_stm32::pac::{self, spi::Spi, spi::vals::Br};
use embassy_stm32::peripherals::SPI3;
use embedded_hal::spi::{ErrorType, Mode, Operation, SpiDevice};
use haptics::FaultKind;

/// Alternate function of SPI3 on its pins.
const FUNCTION: u8 = 6;
/// Longest time from power-up to an answer, ms.
const STARTS_MS: u32 = 50;

static MEMORY: Memory<12> = Memory::new();

pub struct Spi3;

impl Line<12> for Spi3 {
    type Clock = SPI3;
    const SPI: Spi = pac::SPI3;
    const MODE: Mode = MODE_OF_BUS;
    // 10.6 MHz, of the 25 MHz that the chip follows: a frame takes 9 µs
    const RATE: Br = Br::DIV16;
    const CHANNELS: [usize; 3] = [3, 4, 5];
    // TIM7 update, because a request starts one channel only; SPI3 receive and transmit
    const REQUESTS: [u8; 3] = [9, 14, 15];

    fn memory() -> &'static Memory<12> {
        &MEMORY
    }
}

/// The force from the 24-bit converter.
pub struct Load24(LoadCell<Frames<Spi3, 12>>);

impl Load24 {
    /// Takes NSS, SCK, MISO and MOSI of SPI3, and sets the converter up. Without an answer the first sample is a fault.
    pub fn new(pins: [Peri<'static, AnyPin>; 4], supply: f32) -> Self {
        let mut frames = Frames::new(pins, FUNCTION, READ);
        let _ = (0..STARTS_MS).find(|_| {
            cortex_m::asm::delay(TICK_HZ / 1_000);
            configure(&mut Now(&mut frames)).is_ok()
        });
        frames.send(READ);
        Self(LoadCell::new(frames, supply))
    }

    /// Reads the converter with every latch of the force, for the next control period.
    pub fn follow() {
        Frames::<Spi3, 12>::follow();
        // last: a reset of the timer clears it
        pac::TIM7.dier().modify(|w| w.set_ude(true));
    }

    /// Code of the force.
    #[inline(always)]
    pub fn sample(&mut self, _: u16) -> u16 {
        self.0.sample()
    }

    /// Fault of the last sample.
    #[inline(always)]
    pub const fn trouble(&self) -> Option<FaultKind> {
        self.0.trouble()
    }
}

/// The same bus before the timer runs, one frame at a time: a transfer sends its own frame, and waits for the answer.
struct Now<'a>(&'a mut Frames<Spi3, 12>);

/// Longest frame, µs.
const FRAME_US: u32 = 20;

impl ErrorType for Now<'_> {
    type Error = Unfinished;
}

impl SpiDevice for Now<'_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Unfinished> {
        if let [Operation::TransferInPlace(bytes)] = operations
            && let Ok(bytes) = <&mut [u8; 12]>::try_from(&mut **bytes)
        {
            self.0.send(*bytes);
            self.0.start();
            cortex_m::asm::delay(TICK_HZ / 1_000_000 * FRAME_US);
            self.0.transfer_in_place(bytes)
        } else {
            Err(Unfinished)
        }
    }
}
