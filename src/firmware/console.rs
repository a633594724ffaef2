//! Moves bytes between the serial line and the desk, once a millisecond.
//!
//! Polled, not awaited: embassy's buffered writer does not wake a task that waits for room. A byte waits at most a
//! millisecond, the smaller buffer holds eleven.

use embassy_futures::poll_once;
use embassy_stm32::usart::{BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_time::{Duration, Instant, Ticker};
use embedded_io_async::{Read, Write};
use haptics::FaultKind;
use tribos_firmware::app::{Desk, DeskEnds};
use tribos_firmware::board::nucleo_g474re::{self as board, Nucleo, RX_BYTES};

/// Bytes handed to the line at a time: a piece is taken whole or not at all.
const PIECE: usize = 64;

#[embassy_executor::task]
pub async fn run(desk: &'static mut Desk, mut ends: DeskEnds<'static>, line: BufferedUart<'static>) {
    let (mut tx, mut rx) = line.split();
    let mut board = Nucleo;
    let mut typed = Typed::new();
    let mut pulse = Pulse { steps: board::steps(), seen: Instant::now() };
    let mut tick = Ticker::every(Duration::from_millis(1));
    loop {
        tick.next().await;
        pulse.look();
        typed.fill(&mut rx);
        // the second time for what the first has made room for
        for _ in 0..2 {
            let taken = desk.receive(typed.rest(), &mut ends, &mut board);
            typed.taken(taken);
            desk.poll(&mut ends, &mut board);
        }
        send(desk, &mut tx);
    }
}

fn send(desk: &mut Desk, tx: &mut BufferedUartTx<'static>) {
    loop {
        let front = desk.output().front();
        let piece = &front[..front.len().min(PIECE)];
        if piece.is_empty() {
            return;
        }
        let core::task::Poll::Ready(Ok(sent)) = poll_once(tx.write(piece)) else { return };
        desk.output().sent(sent);
    }
}

/// Longest time without a control step.
const STANDSTILL: Duration = Duration::from_millis(3);

/// Whether the loop lives: looked at here because this task looks up most often.
struct Pulse {
    steps: u32,
    seen: Instant,
}

impl Pulse {
    /// Force off and a restart when no step came for [`STANDSTILL`]: nobody else is left to say so.
    fn look(&mut self) {
        let steps = board::steps();
        if steps != self.steps {
            *self = Self { steps, seen: Instant::now() };
        } else if self.seen.elapsed() > STANDSTILL {
            board::restart(FaultKind::MissedDeadline);
        }
    }
}

/// What came in and is not yet taken.
struct Typed {
    // one more than the line's buffer holds
    bytes: [u8; RX_BYTES + 1],
    from: usize,
    to: usize,
}

impl Typed {
    fn new() -> Self {
        Self { bytes: [0; RX_BYTES + 1], from: 0, to: 0 }
    }

    fn rest(&self) -> &[u8] {
        self.bytes.get(self.from..self.to).unwrap_or(&[])
    }

    fn taken(&mut self, count: usize) {
        self.from += count;
    }

    /// Takes over what the line's buffer holds, once all before is taken.
    fn fill(&mut self, rx: &mut BufferedUartRx<'static>) {
        if self.from < self.to {
            return;
        }
        (self.from, self.to) = (0, 0);
        if let core::task::Poll::Ready(Ok(count)) = poll_once(rx.read(&mut self.bytes[..RX_BYTES])) {
            self.to = count;
            if count == RX_BYTES {
                // a full buffer has lost what came next. A zero in its place makes the desk refuse that line:
                // the halves of two commands must never be obeyed as one
                self.bytes[count] = 0;
                self.to += 1;
            }
        }
    }
}
