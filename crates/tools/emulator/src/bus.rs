//! Maps loads and stores of the core to registers of the chip.

use crate::flash::BANK_2;
use crate::recording::Recording;
use crate::soc::Soc;
use crate::wait::{self, Literals};
use rsemu::core::BusError;
use rsemu::core::space::{MemAttrs, MemOps, MemResult, RomStore};
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// The address space of the peripherals, without those of the core.
pub(crate) const PERIPHERALS: u32 = 0x4000_0000;
pub(crate) const PERIPHERALS_END: u32 = 0x6000_0000;

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
    literals: Mutex<Literals>,
    /// Address of the running instruction.
    pub pc: AtomicU32,
    /// Name, value after a reset and fields of each register whose reserved bits are watched.
    pub watched: OnceLock<HashMap<u32, (String, u32, u32)>>,
    pub recording: OnceLock<Recording>,
    soc: Mutex<Soc>,
}

impl Shared {
    pub fn new(soc: Soc) -> Self {
        Self {
            now: AtomicU64::new(0),
            touched: AtomicBool::new(true),
            waited: AtomicU64::new(0),
            flash_loads: AtomicU64::new(0),
            literals: Mutex::new(Literals::new()),
            pc: AtomicU32::new(0),
            watched: OnceLock::new(),
            recording: OnceLock::new(),
            soc: Mutex::new(soc),
        }
    }

    /// The chip, for a change from outside.
    pub fn soc(&self) -> MutexGuard<'_, Soc> {
        let mut soc = self.running();
        soc.forget_next_event();
        soc
    }

    /// The chip, for what it does on its own: reads, writes and the course of time.
    pub fn running(&self) -> MutexGuard<'_, Soc> {
        self.soc.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for loads from flash.
    pub fn literals(&self) -> MutexGuard<'_, Literals> {
        self.literals.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reserved bits keep their value after a reset [rm0440, "List of abbreviations for registers"]. `lanes` are the bits that a
    /// store of one to four bytes writes.
    fn watch_reserved(&self, address: u32, word: u32, lanes: u32) {
        let Some(registers) = self.watched.get() else { return };
        let pc = self.pc.load(Relaxed);
        let why = match registers.get(&address) {
            Some((name, reset, fields)) => {
                let changed = (word ^ reset) & !fields & lanes;
                if changed == 0 {
                    return;
                }
                format!(
                    "reserved bits {changed:#x} of {name} ({address:#x}) changed by {word:#x} at pc {pc:#x}"
                )
            }
            None => format!("{word:#x} written to {address:#x}, which is no register, at pc {pc:#x}"),
        };
        self.running().violations.insert(why);
    }

    /// Counts a load from bank 1 of the flash, and waits for it.
    pub fn load_from_flash(&self, address: u32) {
        let cycles = self.literals().load(address);
        self.flash_loads.store(self.flash_loads.load(Relaxed) + 1, Relaxed);
        self.wait(cycles);
    }

    /// Loads from a peripheral.
    pub fn load(&self, address: u32, data: &mut [u8]) {
        self.wait(wait::bus(address).0);
        let word = self.running().read(address & !3, self.now.load(Relaxed));
        let bytes = (word >> (8 * (address & 3))).to_le_bytes();
        for (to, from) in data.iter_mut().zip(bytes) {
            *to = from;
        }
        if let Some(recording) = self.recording.get() {
            recording.read(address, data);
        }
        self.touched.store(true, Relaxed);
    }

    /// Stores to a peripheral.
    pub fn store(&self, address: u32, data: &[u8]) {
        self.wait(wait::bus(address).1);
        if let Some(recording) = self.recording.get() {
            recording.write(address, data);
        }
        let mut bytes = [0; 4];
        for (to, from) in bytes.iter_mut().zip(data) {
            *to = *from;
        }
        // peripherals take a narrow store as the register's low part, zero extended
        let word = u32::from_le_bytes(bytes) << (8 * (address & 3));
        let lanes = (u64::MAX >> (64 - 8 * data.len().clamp(1, 4))) as u32;
        self.watch_reserved(address & !3, word, lanes << (8 * (address & 3)));
        self.running().write(address & !3, word, self.now.load(Relaxed));
        self.touched.store(true, Relaxed);
    }

    // only the thread that runs the core comes here
    fn wait(&self, cycles: u64) {
        if cycles > 0 {
            self.waited.store(self.waited.load(Relaxed) + cycles, Relaxed);
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
        self.shared.load(self.base + offset as u32, data);
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8], _: MemAttrs) -> MemResult {
        self.shared.store(self.base + offset as u32, data);
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
            self.shared.load_from_flash(self.base + offset as u32);
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
        let mut soc = self.0.running();
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
        self.with(|soc, now| soc.flash.fetch(offset as u32, data, now))?;
        if let Some(recording) = self.0.recording.get() {
            recording.read(BANK_2 + offset as u32, data);
        }
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8], _: MemAttrs) -> MemResult {
        if let Some(recording) = self.0.recording.get() {
            recording.write(BANK_2 + offset as u32, data);
        }
        self.with(|soc, now| soc.flash.store(offset as u32, data, now))
    }
}
