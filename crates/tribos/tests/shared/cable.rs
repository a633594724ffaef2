//! The virtual device on a port.

use serialport::{SerialPort, TTYPort};
use std::io::{Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU8, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// A device behind a pseudo-terminal; dropping it is pulling its cable.
pub struct Cable {
    pub name: String,
    pulled: Arc<AtomicBool>,
    /// State of the machine, and force, mN.
    pub now: Arc<(AtomicU8, AtomicI32)>,
    thread: Option<thread::JoinHandle<()>>,
}

impl Cable {
    /// A virtual device that knows the middle of its stroke.
    pub fn plug() -> Self {
        let mut device = tribos_firmware::VirtualDevice::new(&Default::default()).expect("a device");
        device.home().expect("both stops");
        Self::to(device, |_| {})
    }

    /// This device; `garble` changes the bytes it sends.
    pub fn to(
        mut device: tribos_firmware::VirtualDevice,
        garble: impl Fn(&mut Vec<u8>) + Send + 'static,
    ) -> Self {
        let (mut ours, theirs) = TTYPort::pair().expect("a pseudo-terminal");
        let name = theirs.name().expect("its name");
        ours.set_timeout(Duration::from_millis(1)).expect("a time-out");
        let pulled = Arc::new(AtomicBool::new(false));
        let seen = pulled.clone();
        let now = Arc::<(AtomicU8, AtomicI32)>::default();
        let told = now.clone();
        let thread = thread::spawn(move || {
            // ours and theirs live until the cable is pulled
            let _theirs = theirs;
            let (mut due, mut out, mut chunk) = (Instant::now(), Vec::new(), [0; 512]);
            while !seen.load(Ordering::SeqCst) {
                if let Ok(count) = ours.read(&mut chunk) {
                    device.write(&chunk[..count]);
                }
                while due <= Instant::now() {
                    device.tick();
                    due += Duration::from_millis(1);
                }
                told.0.store(device.mode().code(), Ordering::SeqCst);
                told.1.store((1e3 * device.outputs().force) as i32, Ordering::SeqCst);
                let mut sent = Vec::new();
                device.read(&mut sent);
                garble(&mut sent);
                out.append(&mut sent);
                // a line that is full waits
                while let Ok(count @ 1..) = ours.write(&out) {
                    out.drain(..count);
                }
            }
        });
        Self { name, pulled, now, thread: Some(thread) }
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        self.pulled.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
