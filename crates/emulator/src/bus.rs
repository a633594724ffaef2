//! Loads and stores of the core become register accesses of the chip.

use crate::soc::Soc;
use rsemu::core::space::{MemAttrs, MemOps, MemResult};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What the core and the chip share.
#[derive(Debug)]
pub(crate) struct Shared {
    /// Virtual time of the instruction that runs.
    pub now: AtomicU64,
    /// A register was touched: interrupts and events are to be looked at again.
    pub touched: AtomicBool,
    soc: Mutex<Soc>,
}

impl Shared {
    pub fn new(soc: Soc) -> Self {
        Self { now: AtomicU64::new(0), touched: AtomicBool::new(true), soc: Mutex::new(soc) }
    }

    pub fn soc(&self) -> MutexGuard<'_, Soc> {
        self.soc.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A window of the address space.
#[derive(Debug)]
pub(crate) struct Window {
    pub shared: Arc<Shared>,
    pub base: u32,
}

impl MemOps for Window {
    fn read(&self, offset: u64, data: &mut [u8], _: MemAttrs) -> MemResult {
        let address = self.base + offset as u32;
        let word = self.shared.soc().read(address & !3, self.shared.now.load(Relaxed));
        let bytes = (word >> (8 * (address & 3))).to_le_bytes();
        for (to, from) in data.iter_mut().zip(bytes) {
            *to = from;
        }
        self.shared.touched.store(true, Relaxed);
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8], _: MemAttrs) -> MemResult {
        let address = self.base + offset as u32;
        let mut bytes = [0; 4];
        for (to, from) in bytes.iter_mut().zip(data) {
            *to = *from;
        }
        // peripherals take a narrow store as the register's low part, zero extended
        let word = u32::from_le_bytes(bytes) << (8 * (address & 3));
        self.shared.soc().write(address & !3, word, self.shared.now.load(Relaxed));
        self.shared.touched.store(true, Relaxed);
        Ok(())
    }
}

/// Bank 2 of the flash.
#[derive(Debug)]
pub(crate) struct Bank2(pub Arc<Shared>);

impl Bank2 {
    fn with(&self, access: impl FnOnce(&mut Soc, u64)) -> MemResult {
        let mut soc = self.0.soc();
        access(&mut soc, self.0.now.load(Relaxed));
        let violation = soc.flash.violation.take();
        soc.violations.extend(violation);
        // of loads there are too many to look at everything after each
        if soc.flash.nmi || soc.flash.power_lost {
            self.0.touched.store(true, Relaxed);
        }
        Ok(())
    }
}

impl MemOps for Bank2 {
    fn read(&self, offset: u64, data: &mut [u8], _: MemAttrs) -> MemResult {
        self.with(|soc, now| soc.flash.fetch(offset as u32, data, now))
    }

    fn write(&self, offset: u64, data: &[u8], _: MemAttrs) -> MemResult {
        self.with(|soc, now| soc.flash.store(offset as u32, data, now))
    }
}
