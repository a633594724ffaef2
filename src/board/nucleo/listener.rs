//! Executor of the task that listens to the serial line, in an interrupt of its own above all other tasks.
//!
//! The serial line wakes it when it falls idle, so that it hears an `off` some microseconds after its last byte, and in a
//! flood every [`super::serial::RX_WAKE`] bytes.

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::{InterruptExt, Priority};

/// Raised by software only: nothing else uses UART5.
static EXECUTOR: InterruptExecutor = InterruptExecutor::new();

#[interrupt]
fn UART5() {
    // SAFETY: called from its interrupt only, which `start` enables once the executor is initialised.
    unsafe { EXECUTOR.on_interrupt() }
}

/// Starts the executor. Called once.
pub(super) fn start() -> SendSpawner {
    interrupt::UART5.set_priority(Priority::P7);
    EXECUTOR.start(interrupt::UART5)
}
