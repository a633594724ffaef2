//! The serial line: each received byte takes an interrupt, so that `off` is heard at once; what is sent goes by DMA.
//!
//! The HAL has a driver for each, but none for both on one peripheral. The one that receives is opened last: opening resets the
//! peripheral, and it switches both directions on. The DMA is asked for anew with each piece.

use super::{BAUD, RX_BYTES, RX_WAKE, chip};
use embassy_stm32::Peri;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH7, PA2, PA3};
use embassy_stm32::usart::{BufferedUart, BufferedUartRx, Config, UartTx};
use static_cell::StaticCell;

/// The serial line of the ST-LINK.
pub struct Serial {
    /// What is received.
    pub rx: BufferedUartRx<'static>,
    /// What is sent.
    pub tx: UartTx<'static, Async>,
}

impl Serial {
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
