//! Runs the ELF that would be flashed on an emulated STM32G474 around the simulated rig.
//!
//! [`Machine::boot`] loads the image as a programmer would, at its physical addresses, resets the core and runs it
//! in virtual time against models of the peripherals that the firmware uses, one file each. The rig of
//! [`plant`] is connected to the pins: the DAC code is a force while the amplifier enable pin is high, encoder edges reach
//! TIM2 at the instant they happen, load cell and accelerometer are levels on ADC inputs.
//!
//! ```text
//!            TIM6 --trgo--> ADC1 --JEOS--> core --> DAC1 holding --TIM7 trgo--> force --.
//!  rig edges --> TIM2 --encoder clock--> TIM5 capture                                  v
//!      ^---------------------------------------------------------------------------- rig
//! ```
//!
//! The models are strict where a wrong register setting would go unnoticed otherwise: trigger sources, capture
//! input, oversampling, alignment, clock tree, pin functions and peripheral clocks are decoded from the registers,
//! and violations of the data sheet are recorded in [`Machine::violations`].
//!
//! | decoded | not modelled |
//! | --- | --- |
//! | RCC: PLL, switch, AHB and APB1 dividers, clock muxes of ADC and LPUART1, enables, reset flags; wait states and boost against the frequency | oscillator start-up, CSS, low-power modes, resets by RCC_xRSTR |
//! | ADC1: injected sequence, JEXTSEL and JEXTEN, OVSR, OVSS, SMPR, clock and its limit, busy, frozen settings | regular sequence, DMA, watchdogs, analogue errors, calibration |
//! | DAC1 channel 1: EN, TEN, TSEL, the three alignments, HFSEL against the bus | channel 2, waveforms, output buffer |
//! | TIM2-7: PSC preload, ARR, update and compare flags, encoder mode 3, CC inputs, TS, capture on TRC, MMS 2 and 8, one-pulse mode, outputs by PWM 1 and 2 and forced | encoder modes 1 and 2 (count nothing), input filter, dead time |
//! | LPUART1: rate, FIFO, RXNE, TXE, TC, IDLE, overrun, framing, DMA requests to send | parity, DMA requests to receive, wake-up |
//! | SPI2 and SPI3: master of 8 bits, mode, rate against the chip's, FIFOs, NSS by hardware, DMA requests; an MT6835 and an ADS131M02 | CRC, slave, other sizes |
//! | DMA1 and DMAMUX1: requests of TIM6, TIM7, SPI2, SPI3 and LPUART1, both directions, increment, circular; flags of end and half; the interrupt of channel 7 | time on the bus, the error flag, other interrupts |
//! | IWDG: keys, prescaler, reload | window |
//! | GPIO: modes, alternate functions, pulls, levels | speed, open drain, lock |
//! | NVIC: priorities; a control interrupt that waits for another handler is recorded | |
//!
//! Cycles are those of the interpreter, about one an instruction and one more an access, and what the core waits for flash, CCM
//! SRAM and buses by the model in `wait.rs`.
//!
//! Two cores execute: rsemu's, and beside it a quick one for the common instructions (`quick.rs`), which the tests hold equal to it
//! in registers, memory and cycles. [`Machine::set_reference`] lets only rsemu execute.
//!
//! Two witnesses that were not written from the same reading of the manual: the vendor's description of the registers ([`svd`]) for
//! addresses, bits, values after a reset and reserved bits; QEMU's Cortex-M4 for the core (`witness/replay.py`, [`Machine::record`]).
//! What a peripheral does with its bits has none.
//!
//! Limits. No arbitration between core and DMA. Registers of unused peripherals read back their written values.
#![forbid(unsafe_code)]

mod adc;
mod ads131m02;
mod alu;
pub mod block;
mod bus;
mod code;
mod dac;
mod dma;
pub mod firmware;
mod flash;
mod flood;
mod gpio;
mod image;
mod inject;
mod iwdg;
mod lpuart;
mod machine;
mod mt6835;
mod quick;
pub mod random;
mod rcc;
mod reach;
mod recording;
pub mod report;
mod soc;
mod spi;
mod stats;
mod supply;
pub mod svd;
mod tim;
mod wait;
mod world;

pub use ads131m02::ConverterFault;
pub use image::{Image, ImageError, system_memory};
pub use inject::Injected;
pub use machine::Machine;
pub use mt6835::EncoderFault;
pub use rcc::ResetCause;
pub use reach::{Lost, Reach};
pub use stats::{Statistics, Summary};

/// Units of virtual time per second: an integer for a cycle of 170 MHz (1 600) and of 16 MHz (17 000), and fine enough for an
/// oscillator that is off by a part in 1 000.
pub const UNITS_PER_SECOND: u64 = 272_000_000_000;
/// Units of virtual time in a millisecond.
pub const UNITS_PER_MS: u64 = UNITS_PER_SECOND / 1_000;

/// Virtual time of one period of a clock, units; 0 Hz never ticks.
pub(crate) fn units_per_cycle(hz: u64) -> u64 {
    (UNITS_PER_SECOND + hz / 2).checked_div(hz).map_or(u64::MAX / 4, |units| units.max(1))
}
