//! Task that sends what the console hands over: by DMA, a piece after the other without a gap.

use embassy_stm32::mode::Async;
use embassy_stm32::usart::UartTx;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::pipe::{Pipe, Reader};

/// Bytes that can wait to be sent: 8 ms of the line.
const WAITING: usize = 768;

/// What waits to be sent. Between tasks of one executor, so without a critical section.
pub type Sending = Pipe<NoopRawMutex, WAITING>;
/// The end of the console.
pub type Writer = embassy_sync::pipe::Writer<'static, NoopRawMutex, WAITING>;

#[embassy_executor::task]
pub async fn run(mut sending: Reader<'static, NoopRawMutex, WAITING>, mut tx: UartTx<'static, Async>) {
    loop {
        let piece = sending.fill_buf().await;
        let sent = piece.len();
        // the HAL reports no error of what is sent
        let _ = tx.write(piece).await;
        sending.consume(sent);
    }
}
