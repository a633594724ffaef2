//! A pseudo-terminal as the serial line.

use serialport::{SerialPort, TTYPort};
use std::io::{ErrorKind, Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Duration;

/// Largest number of bytes waiting for the other end. Beyond it nobody reads, and bytes are dropped as on an open cable. The
/// host sees it in the sequence numbers.
const UNREAD: usize = 1 << 20;

/// One end of a pseudo-terminal. The other end has a name in the file system.
pub struct Pty {
    name: String,
    from_host: Receiver<Vec<u8>>,
    to_host: Sender<Vec<u8>>,
    unread: Arc<AtomicUsize>,
    /// Whether the host has written. Until then nothing is sent, so that a host finds no old answers.
    attached: std::cell::Cell<bool>,
    /// Other end, held open so that a host can come and go.
    _other_end: TTYPort,
}

impl Pty {
    /// Opens a pseudo-terminal.
    ///
    /// # Errors
    /// The reason of the system.
    pub fn open() -> Result<Self, String> {
        let text = |e: serialport::Error| e.to_string();
        let (mut reader, other_end) = TTYPort::pair().map_err(text)?;
        let name = other_end.name().ok_or("the pseudo-terminal has no name")?;
        reader.set_timeout(Duration::from_millis(100)).map_err(text)?;
        let mut writer = reader.try_clone_native().map_err(text)?;
        let (heard, from_host) = channel();
        thread::spawn(move || {
            let mut chunk = [0; 1024];
            loop {
                match reader.read(&mut chunk) {
                    Ok(count) => {
                        if heard.send(chunk[..count].to_vec()).is_err() {
                            return;
                        }
                    }
                    Err(e) if matches!(e.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
                    Err(_) => thread::sleep(Duration::from_millis(50)),
                }
            }
        });
        let (to_host, said) = channel::<Vec<u8>>();
        let unread = Arc::new(AtomicUsize::new(0));
        let waiting = unread.clone();
        thread::spawn(move || {
            for bytes in said {
                let mut rest = bytes.as_slice();
                while !rest.is_empty() {
                    match writer.write(rest) {
                        Ok(count) => rest = &rest[count..],
                        Err(e) if matches!(e.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
                        Err(_) => break,
                    }
                }
                waiting.fetch_sub(bytes.len(), SeqCst);
            }
        });
        Ok(Self { name, from_host, to_host, unread, attached: false.into(), _other_end: other_end })
    }

    /// Name of the other end.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Received bytes.
    pub fn received(&self) -> Option<Vec<u8>> {
        let bytes = self.from_host.try_recv().ok()?;
        self.attached.set(true);
        Some(bytes)
    }

    /// Sends bytes to the other end. Never blocks.
    pub fn send(&mut self, bytes: &[u8]) {
        if bytes.is_empty() || !self.attached.get() {
            return;
        }
        if self.unread.load(SeqCst) + bytes.len() <= UNREAD {
            self.unread.fetch_add(bytes.len(), SeqCst);
            // the thread lives as long as this end
            let _ = self.to_host.send(bytes.to_vec());
        }
    }
}
