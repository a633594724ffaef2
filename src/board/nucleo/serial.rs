//! The serial line: each received byte takes an interrupt, so that `off` is heard at once; what is sent goes by DMA.
//!
//! embassy has no driver that does both, so [`UartTx`] and [`BufferedUart`] share the peripheral. [`BufferedUart`] is opened last:
//! opening a driver resets the peripheral, and this one enables both directions. [`UartTx`] sets CR3.DMAT, which the reset
//! clears, at every write.

use super::chip;
use embassy_stm32::Peri;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH7, PA2, PA3};
use embassy_stm32::usart::{BufferedUart, BufferedUartRx, Config, UartTx};
use static_cell::StaticCell;

/// Baud rate.
const BAUD: u32 = 921_600;
/// Received bytes that can wait for the listener: 5 ms of the line.
pub const RX_BYTES: usize = 512;
/// Bytes after which the listener is woken while the line does not fall idle: 0.35 ms.
pub(super) const RX_WAKE: usize = 32;

/// The serial line of the ST-LINK.
pub struct SerialLine {
    /// What is received.
    pub rx: BufferedUartRx<'static>,
    /// What is sent.
    pub tx: UartTx<'static, Async>,
}

impl SerialLine {
    /// Opens it, once.
    pub(super) fn open(tx: Peri<'static, PA2>, rx: Peri<'static, PA3>, dma: Peri<'static, DMA1_CH7>) -> Self {
        let mut settings = Config::default();
        settings.baudrate = BAUD;
        settings.eager_reads = Some(RX_WAKE);
        static RX: StaticCell<[u8; RX_BYTES]> = StaticCell::new();
        // the driver wants one, and nothing is written to it
        static UNUSED: StaticCell<[u8; 1]> = StaticCell::new();
        // SAFETY: the peripheral and the pin are those of these two drivers for good, of which one only sends and the other only
        // receives.
        let (sends, receives, pin) =
            unsafe { (chip::Serial::steal(), chip::Serial::steal(), tx.clone_unchecked()) };
        // pins and rate are constants: neither can fail
        let sender = UartTx::new(sends, pin, dma, chip::Irqs, settings);
        let receiver = BufferedUart::new(
            receives,
            rx,
            tx,
            UNUSED.init([0]),
            RX.init([0; RX_BYTES]),
            chip::Irqs,
            settings,
        );
        let (Ok(tx), Ok(receiver)) = (sender, receiver) else { panic!("the serial line at 921 600 baud") };
        let (unused, rx) = receiver.split();
        // dropping it would disconnect the pin
        core::mem::forget(unused);
        Self { rx, tx }
    }
}
