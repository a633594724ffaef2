//! The virtual device in real time, with its serial line.

use super::pty::Pty;
use haptics::ModeId;
use link::{Decoder, Item};
use std::time::{Duration, Instant};
use tribos_firmware::VirtualDevice;

/// Longest continuation of a motion, s.
const FINISH_S: f64 = 120.0;
/// Longest time to catch up after the PC was busy. The rest is skipped.
const CATCH_UP: Duration = Duration::from_millis(250);

/// The device in real time, and its serial line.
pub(super) struct Running {
    pub device: VirtualDevice,
    pty: Option<Pty>,
    decoder: Decoder,
    bytes: Vec<u8>,
    lines: Vec<String>,
    period: Duration,
    /// Time of the next control period.
    due: Instant,
}

impl Running {
    pub fn new(device: VirtualDevice, pty: Option<Pty>) -> Self {
        let period = Duration::from_secs_f64(device.period());
        let (decoder, bytes, lines) = (Decoder::new(), Vec::new(), Vec::new());
        Self { device, pty, decoder, bytes, lines, period, due: Instant::now() }
    }

    /// Advances the device to the present time. Returns its lines.
    pub fn live(&mut self) -> Vec<String> {
        let now = Instant::now();
        if now.saturating_duration_since(self.due) > CATCH_UP {
            self.due = now - CATCH_UP;
        }
        if let Some(pty) = &self.pty {
            while let Some(bytes) = pty.received() {
                self.device.write(&bytes);
            }
        }
        while self.due <= now {
            self.tick();
            self.due += self.period;
        }
        self.carry();
        std::mem::take(&mut self.lines)
    }

    /// Executes a command as fast as possible. Returns the lines until the device is quiet.
    pub fn obey(&mut self, line: &[u8]) -> Vec<String> {
        self.device.write(line);
        if !line.ends_with(b"\n") {
            self.device.write(b"\n");
        }
        // a self-test takes half a second, the longest of all commands
        for _ in 0..5_000 {
            self.tick();
            self.carry();
            if self.device.is_quiet() {
                break;
            }
        }
        std::mem::take(&mut self.lines)
    }

    /// Advances as fast as possible until a motion ends. Returns the lines of this time.
    pub fn finish(&mut self, is_running: impl Fn(ModeId) -> bool) -> Vec<String> {
        let mut left = 0..(FINISH_S / self.period.as_secs_f64()) as u64;
        while (is_running(self.device.mode()) || !self.device.is_quiet()) && left.next().is_some() {
            self.tick();
        }
        self.carry();
        std::mem::take(&mut self.lines)
    }

    fn tick(&mut self) {
        self.device.tick();
        self.device.read(&mut self.bytes);
    }

    /// Sends bytes to the pseudo-terminal and lines to the console.
    fn carry(&mut self) {
        if let Some(pty) = &mut self.pty {
            pty.send(&self.bytes);
        }
        for byte in self.bytes.drain(..) {
            if let Some(Item::Text(line)) = self.decoder.push(byte) {
                self.lines.push(line.to_owned());
            }
        }
    }
}
