//! Task that listens to the serial line, above all other tasks: it passes bytes on, and obeys `off` at once.

use embassy_stm32::usart::BufferedUartRx;
use embedded_io_async::Read;
use heapless_spsc::spsc::Producer;
use tribos_firmware::app::{Listener, OffSwitch};
use tribos_firmware::board::nucleo as board;

/// Bytes that can wait for the console: two pasted pages, 88 ms of the line.
pub const WAITING: usize = 8192;

#[embassy_executor::task]
pub async fn run(
    mut line: BufferedUartRx<'static>,
    mut queue: Producer<'static, u8, WAITING>,
    off: &'static OffSwitch,
) {
    let mut listener = Listener::new();
    let mut bytes = [0; board::RX_BYTES];
    loop {
        // an error of the line is in the bytes, if anywhere
        let Ok(count) = line.read(&mut bytes).await else { continue };
        for byte in bytes.iter().take(count) {
            if listener.hear(*byte, off, |byte| queue.enqueue(byte).is_ok()) {
                // the control loop, asked before, keeps it low
                board::enable::drop_now();
            }
        }
        if count == board::RX_BYTES {
            // a full buffer may have lost what came next
            listener.lose();
        }
    }
}
