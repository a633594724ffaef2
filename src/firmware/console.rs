//! Task that moves bytes between listener, desk and sender every millisecond.

use super::listener::WAITING;
use super::sender::Writer;
use embassy_time::{Duration, Instant, Ticker};
use haptics::FaultKind;
use heapless_spsc::spsc::Consumer;
use tribos_firmware::app::{Desk, DeskEnds};
use tribos_firmware::board::nucleo::{self as board, Nucleo};

#[embassy_executor::task]
pub async fn run(
    desk: &'static mut Desk,
    mut ends: DeskEnds<'static>,
    queue: Consumer<'static, u8, WAITING>,
    tx: Writer,
) {
    let mut board = Nucleo;
    let mut typed = Typed::new(queue);
    let mut pulse = Pulse { steps: board::steps(), seen: Instant::now() };
    let mut tick = Ticker::every(Duration::from_millis(1));
    loop {
        tick.next().await;
        pulse.look();
        // a second time, for room made by the first
        for _ in 0..2 {
            typed.fill();
            let taken = desk.receive(typed.rest(), &mut ends, &mut board);
            typed.taken(taken);
            desk.poll(&mut ends, &mut board);
        }
        send(desk, &tx);
    }
}

/// Hands over what there is room for.
fn send(desk: &mut Desk, tx: &Writer) {
    loop {
        let front = desk.output().front();
        if front.is_empty() {
            return;
        }
        let Ok(taken) = tx.try_write(front) else { return };
        desk.output().sent(taken);
    }
}

/// Longest time without a control step.
const STANDSTILL: Duration = Duration::from_millis(3);

/// Detects a stopped loop. Here, because this task runs most often.
struct Pulse {
    steps: u32,
    seen: Instant,
}

impl Pulse {
    /// Switches the force off and restarts if no step came for [`STANDSTILL`].
    fn look(&mut self) {
        let steps = board::steps();
        if steps != self.steps {
            *self = Self { steps, seen: Instant::now() };
        } else if self.seen.elapsed() > STANDSTILL {
            board::restart(FaultKind::MissedDeadline);
        }
    }
}

/// Received bytes that are not yet read.
struct Typed {
    queue: Consumer<'static, u8, WAITING>,
    bytes: [u8; CHUNK],
    from: usize,
    to: usize,
}

/// Bytes offered to the desk at once: what the line brings in a period, and as much again.
const CHUNK: usize = 192;

impl Typed {
    fn new(queue: Consumer<'static, u8, WAITING>) -> Self {
        Self { queue, bytes: [0; CHUNK], from: 0, to: 0 }
    }

    fn rest(&self) -> &[u8] {
        self.bytes.get(self.from..self.to).unwrap_or(&[])
    }

    fn taken(&mut self, count: usize) {
        self.from += count;
    }

    /// Takes bytes from the queue once all earlier ones are read.
    fn fill(&mut self) {
        if self.from < self.to {
            return;
        }
        (self.from, self.to) = (0, 0);
        for place in &mut self.bytes {
            let Some(byte) = self.queue.dequeue() else { break };
            *place = byte;
            self.to += 1;
        }
    }
}
