//! Maps loads and stores of the core to registers of the chip.

use crate::soc::Soc;
use crate::wait::{self, Waits};
use rsemu::core::BusError;
use rsemu::core::space::{MemAttrs, MemOps, MemResult, RomStore};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// State shared by core and chip.
#[derive(Debug)]
pub(crate) struct Shared {
    /// Virtual time of the running instruction.
    pub now: AtomicU64,
    /// A register was accessed: interrupts and events must be checked again.
    pub touched: AtomicBool,
    /// Cycles that the running instruction waited for its loads and stores.
    pub waited: AtomicU64,
    /// Loads from flash.
    pub flash_loads: AtomicU64,
    pub waits: Mutex<Waits>,
    soc: Mutex<Soc>,
}

impl Shared {
    pub fn new(soc: Soc) -> Self {
        Self {
            now: AtomicU64::new(0),
            touched: AtomicBool::new(true),
            waited: AtomicU64::new(0),
            flash_loads: AtomicU64::new(0),
            waits: Mutex::new(Waits::new()),
            soc: Mutex::new(soc),
        }
    }

    pub fn soc(&self) -> MutexGuard<'_, Soc> {
        self.soc.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn waits(&self) -> MutexGuard<'_, Waits> {
        self.waits.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait(&self, cycles: u64) {
        if cycles > 0 {
            self.waited.fetch_add(cycles, Relaxed);
        }
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
        self.shared.wait(wait::bus(address).0);
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
        self.shared.wait(wait::bus(address).1);
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

/// Bank 1 of the flash, read-only.
#[derive(Debug)]
pub(crate) struct Bank1 {
    pub shared: Arc<Shared>,
    pub store: Arc<RomStore>,
    pub base: u32,
}

impl MemOps for Bank1 {
    fn read(&self, offset: u64, data: &mut [u8], attrs: MemAttrs) -> MemResult {
        // the wait for a fetch depends on the instruction, which the machine knows
        if !attrs.is_fetch() && !attrs.debug {
            let cycles = self.shared.waits().load(self.base + offset as u32);
            self.shared.flash_loads.fetch_add(1, Relaxed);
            self.shared.wait(cycles);
        }
        self.store.read_at(offset, data)
    }

    fn write(&self, _: u64, _: &[u8], _: MemAttrs) -> MemResult {
        Err(BusError::BadAccess)
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
        // loads are too frequent to check everything after each
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
