//! Transport of bytes: a serial port, or the virtual device inside this process.

use crate::error::{Error, Result};
use serialport::ErrorKind;
use signals::files::reason;
use std::io::{Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};
use tribos_firmware::{VirtualConfig, VirtualDevice};

/// A transport to a device.
pub trait Transport {
    /// Sends bytes. They are sent when this returns.
    ///
    /// # Errors
    /// The line failed.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Appends what has arrived; waits a few milliseconds for it, on the virtual device a few milliseconds of
    /// *its* time.
    ///
    /// # Errors
    /// The line failed.
    fn receive(&mut self, out: &mut Vec<u8>) -> Result<()>;

    /// Runs a virtual device in real time from now on. No effect on a real one.
    fn in_real_time(&mut self) {}
}

/// A serial port, or a pseudo-terminal such as the one `cargo run` prints.
pub struct Port {
    name: String,
    port: Box<dyn serialport::SerialPort>,
}

/// How long to retry a port that is busy, since a program that just exited may still hold it, and the pause between attempts.
const BUSY: Duration = Duration::from_millis(500);
const PAUSE: Duration = Duration::from_millis(20);

impl Port {
    /// Opens `name` at 921 600 baud.
    ///
    /// # Errors
    /// The port does not exist or is in use; the message lists the existing ports.
    pub fn open(name: &str) -> Result<Self> {
        let begun = Instant::now();
        let open = || serialport::new(name, 921_600).timeout(Duration::from_millis(5)).open();
        let mut opened = open();
        // serialport's kind for a port that is locked, and for one that is not there
        let is_busy = |e: &serialport::Error| e.kind() == ErrorKind::NoDevice && Path::new(name).exists();
        while opened.as_ref().is_err_and(is_busy) && begun.elapsed() < BUSY {
            std::thread::sleep(PAUSE);
            opened = open();
        }
        let port = opened.map_err(|e| {
            let ports = serialport::available_ports().unwrap_or_default();
            Error::Port {
                port: name.to_owned(),
                reason: e.to_string().trim_end_matches('.').to_owned(),
                available: ports.into_iter().map(|p| p.port_name).collect(),
            }
        })?;
        Ok(Self { name: name.into(), port })
    }

    fn gone(&self, e: &std::io::Error) -> Error {
        Error::Gone { port: self.name.clone(), reason: reason(e) }
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

/// Control periods between two polls of a virtual device.
const STRIDE: u32 = 5;
/// Longest delay to catch up.
const CATCH_UP: Duration = Duration::from_millis(50);

/// A virtual device inside this process, at full speed.
pub struct Virtual {
    device: VirtualDevice,
    /// Real time of the next poll.
    due: Option<Instant>,
}

impl Virtual {
    /// Boots a virtual device and lets it search its stops, so that it is referenced.
    ///
    /// # Errors
    /// Invalid configuration of the rig.
    pub fn new(seed: u64) -> Result<Self> {
        let config = VirtualConfig { seed, ..VirtualConfig::default() };
        let mut device = VirtualDevice::new(&config).map_err(|e| Error::Virtual(e.to_string()))?;
        device.home().map_err(Error::Virtual)?;
        Ok(Self { device, due: None })
    }

    /// The device, for changes to its rig.
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
            // short oversleeping is caught up; delays of a busy machine are not
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
