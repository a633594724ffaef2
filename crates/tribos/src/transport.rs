//! Bytes to a device and back: a serial port, or the virtual device inside this process.

use crate::failure::{Failure, Result};
use crate::files::reason;
use std::io::{Read, Write};
use std::time::{Duration, Instant};
use tribos_firmware::{VirtualConfig, VirtualDevice};

/// A line to a device.
pub trait Transport {
    /// Sends bytes; they have left when this returns.
    ///
    /// # Errors
    /// The line is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Appends what has arrived; waits a few milliseconds for it, on the virtual device a few milliseconds of
    /// *its* time.
    ///
    /// # Errors
    /// The line is gone.
    fn receive(&mut self, out: &mut Vec<u8>) -> Result<()>;

    /// From now on a virtual device keeps the pace of the clock on the wall; a real one does so anyway.
    fn in_real_time(&mut self) {}
}

/// A serial port, or a pseudo-terminal such as the one `cargo run` prints.
pub struct Port {
    name: String,
    port: Box<dyn serialport::SerialPort>,
}

impl Port {
    /// Opens `name` at 921 600 baud.
    ///
    /// # Errors
    /// No such port, or it is taken; names the ports that are there.
    pub fn open(name: &str) -> Result<Self> {
        let port = serialport::new(name, 921_600).timeout(Duration::from_millis(5)).open().map_err(|e| {
            let there: Vec<String> =
                serialport::available_ports().unwrap_or_default().into_iter().map(|p| p.port_name).collect();
            let there = match there.len() {
                0 => "no serial port was found; `sim` is the virtual device, or start one with `cargo run --release`".into(),
                _ => format!("ports found: {}; `sim` is the virtual device", there.join(", ")),
            };
            let text = e.to_string();
            Failure::new(format!("port {name}: cannot be opened: {}", text.trim_end_matches('.'))).help(there)
        })?;
        Ok(Self { name: name.into(), port })
    }

    fn gone(&self, e: &std::io::Error) -> Failure {
        Failure::new(format!("port {}: the line is gone: {}", self.name, reason(e)))
    }
}

impl Transport for Port {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let sent = self.port.write_all(bytes).and_then(|()| self.port.flush());
        sent.map_err(|e| self.gone(&e))
    }

    fn receive(&mut self, out: &mut Vec<u8>) -> Result<()> {
        let mut chunk = [0; 4096];
        match self.port.read(&mut chunk) {
            Ok(0) => Err(self.gone(&std::io::ErrorKind::UnexpectedEof.into())),
            Ok(n) => {
                out.extend_from_slice(&chunk[..n]);
                Ok(())
            }
            Err(e) if matches!(e.kind(), std::io::ErrorKind::TimedOut | std::io::ErrorKind::Interrupted) => {
                Ok(())
            }
            Err(e) => Err(self.gone(&e)),
        }
    }
}

/// Control periods between two looks at a virtual device.
const STRIDE: u32 = 5;
/// Longest delay that is caught up.
const CATCH_UP: Duration = Duration::from_millis(50);

/// A virtual device inside this process, as fast as it is asked.
pub struct Virtual {
    device: VirtualDevice,
    /// When the next look is due, in real time.
    due: Option<Instant>,
}

impl Virtual {
    /// Boots one.
    ///
    /// # Errors
    /// The rig cannot be built.
    pub fn new(seed: u64) -> Result<Self> {
        let config = VirtualConfig { seed, ..VirtualConfig::default() };
        let device = VirtualDevice::new(&config).map_err(Failure::new)?;
        Ok(Self { device, due: None })
    }

    /// The device, to put something on its rig.
    pub fn device(&mut self) -> &mut VirtualDevice {
        &mut self.device
    }
}

impl Transport for Virtual {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.device.write(bytes);
        Ok(())
    }

    fn receive(&mut self, out: &mut Vec<u8>) -> Result<()> {
        if let Some(due) = &mut self.due {
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            // a sleep that was a little long is made up for; what a busy machine missed is not
            let late = Instant::now().checked_sub(CATCH_UP).unwrap_or(*due);
            *due = late.max(*due) + Duration::from_secs_f64(self.device.period()) * STRIDE;
        }
        for _ in 0..STRIDE {
            self.device.tick();
        }
        self.device.read(out);
        Ok(())
    }

    fn in_real_time(&mut self) {
        self.due = Some(Instant::now());
    }
}
