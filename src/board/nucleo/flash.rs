//! Flash driver for the presets in the last five pages of bank 2. It never delays the control interrupt.
//!
//! The code runs from bank 1 , and the banks are independent: the processor continues during the 22 ms erasure of a
//! page of bank 2. embassy-stm32's driver allows that too, but masks interrupts while it starts an erasure. The task yields
//! while the flash is busy, so that console and supervisor continue.
//!
//! * The data cache is off during an operation: a read of one bank while the other is written may corrupt it [es0430, "data
//!   cache might be corrupted during flash memory read-while-write operation"].
//! * A torn double word has a wrong error-correcting code, and reading it raises the NMI. The handler here records it for
//!   [`Medium::is_torn`]. Elsewhere in the flash it means a corrupt program: reset.

use super::stop::restart;
use crate::board::chip::{self, BANK_2};
use crate::presets::{Medium, NotStored, Refused};
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use embassy_futures::yield_now;
use embassy_stm32::pac::{self, flash::regs::Sr};
use embassy_sync::blocking_mutex::raw::ThreadModeRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Timer;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use haptics::FaultKind;
use link::MAX_ITEM;

/// Address of the presets. The regions of the linker end the code before bank 2.
const BASE: u32 = chip::PRESETS;
const PAGE: u32 = 2048;
const PAGES: u32 = 5;
/// All errors of FLASH_SR and the end of an operation, cleared by writing 1.
const ALL_FLAGS: u32 = 0xc3fb;
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];

/// Whether a double word with a wrong code was read.
static TORN: AtomicBool = AtomicBool::new(false);

/// An item to store and its result, between the console task and the keeper of the flash, both in thread mode.
static WANTED: Signal<ThreadModeRawMutex, Wanted> = Signal::new();
static STORED: Signal<ThreadModeRawMutex, Result<(), NotStored>> = Signal::new();

/// An item to be stored.
pub struct Wanted {
    key: u8,
    item: heapless::Vec<u8, MAX_ITEM>,
}

impl Wanted {
    /// Next item.
    pub async fn next() -> Self {
        WANTED.wait().await
    }

    /// Key of the item.
    #[must_use]
    pub fn key(&self) -> u8 {
        self.key
    }

    /// Bytes of the item.
    #[must_use]
    pub fn item(&self) -> &[u8] {
        &self.item
    }

    /// Reports the result.
    pub fn done(self, outcome: Result<(), NotStored>) {
        STORED.signal(outcome);
    }
}

/// Passes an item to the keeper of the flash.
pub(super) fn store(key: u8, item: &[u8]) {
    STORED.reset();
    match heapless::Vec::from_slice(item) {
        Ok(item) => WANTED.signal(Wanted { key, item }),
        Err(_) => STORED.signal(Err(NotStored::Full)),
    }
}

/// Result of the last store.
pub(super) fn stored() -> Option<Result<(), NotStored>> {
    STORED.try_take()
}

/// Double words read before other tasks run: reading all pages takes many milliseconds.
const READ_AT_ONCE: u32 = 64;

/// The pages for presets, a singleton.
pub struct Pages {
    /// Double words read since other tasks ran.
    read: u32,
}

impl Pages {
    pub(super) fn new() -> Self {
        Self { read: 0 }
    }

    /// Address of a range at this offset, if it is inside.
    fn address(offset: u32, count: usize) -> Result<u32, Refused> {
        let end = offset.checked_add(count as u32).ok_or(Refused)?;
        if end <= PAGE * PAGES { Ok(BASE + offset) } else { Err(Refused) }
    }

    /// A double word, and whether its code is correct.
    fn read_word(address: u32) -> ([u32; 2], bool) {
        TORN.store(false, Relaxed);
        // SAFETY: inside the pages, aligned; volatile because the controller changes what is there
        let word =
            unsafe { core::ptr::with_exposed_provenance::<[u32; 2]>(address as usize).read_volatile() };
        // the NMI arrives with the data
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        (word, TORN.load(Relaxed))
    }
}

/// Unlocked controller. Dropping locks it again.
struct Unlocked {
    data_cache: bool,
}

impl Unlocked {
    async fn new() -> Result<Self, Refused> {
        let flash = pac::FLASH;
        while flash.sr().read().bsy() {
            yield_now().await;
        }
        let data_cache = flash.acr().read().dcen();
        flash.acr().modify(|w| w.set_dcen(false));
        flash.sr().write_value(Sr(ALL_FLAGS));
        if flash.cr().read().lock() {
            for key in KEYS {
                flash.keyr().write_value(key);
            }
        }
        let unlocked = Self { data_cache };
        if flash.cr().read().lock() { Err(Refused) } else { Ok(unlocked) }
    }

    /// Waits for the running operation.
    async fn done(&self) -> Result<(), Refused> {
        loop {
            let sr = pac::FLASH.sr().read();
            if !sr.bsy() {
                return if sr.0 & ALL_FLAGS & !1 == 0 { Ok(()) } else { Err(Refused) };
            }
            yield_now().await;
        }
    }
}

impl Drop for Unlocked {
    fn drop(&mut self) {
        let flash = pac::FLASH;
        flash.sr().write_value(Sr(ALL_FLAGS));
        flash.cr().write(|w| w.set_lock(true));
        if self.data_cache {
            // may only be reset while off
            flash.acr().modify(|w| w.set_dcrst(true));
            flash.acr().modify(|w| w.set_dcrst(false));
            flash.acr().modify(|w| w.set_dcen(true));
        }
    }
}

impl ErrorType for Pages {
    type Error = Refused;
}

impl ReadNorFlash for Pages {
    const READ_SIZE: usize = 8;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        let mut address = Self::address(offset, bytes.len())?;
        self.read += bytes.len() as u32 / 8;
        if self.read >= READ_AT_ONCE {
            self.read = 0;
            yield_now().await;
        }
        for to in bytes.chunks_exact_mut(8) {
            // a torn double word reads as an ignored one; after `recover` there is none
            let word = match Self::read_word(address) {
                (word, false) => word,
                (_, true) => [0; 2],
            };
            to[..4].copy_from_slice(&word[0].to_le_bytes());
            to[4..].copy_from_slice(&word[1].to_le_bytes());
            address += 8;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        (PAGE * PAGES) as usize
    }
}

impl NorFlash for Pages {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE as usize;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        let from = Self::address(from, to.checked_sub(from).ok_or(Refused)? as usize)?;
        let unlocked = Unlocked::new().await?;
        for page in (from - BANK_2) / PAGE..(BASE + to - BANK_2) / PAGE {
            pac::FLASH.cr().write(|w| {
                w.set_per(true);
                w.set_bker(true); // bank 2
                w.set_pnb(page as u8);
            });
            chip::start_erasure();
            while pac::FLASH.sr().read().bsy() {
                Timer::after_micros(500).await;
            }
            unlocked.done().await?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        let mut address = Self::address(offset, bytes.len())?;
        if !offset.is_multiple_of(8) {
            return Err(Refused);
        }
        let unlocked = Unlocked::new().await?;
        pac::FLASH.cr().write(|w| w.set_pg(true));
        for word in bytes.chunks_exact(8) {
            for half in word.chunks_exact(4) {
                let half = half.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
                // SAFETY: inside the pages, aligned; the controller takes both halves as one double word in spite of
                // interrupts, because there is no other writer
                unsafe {
                    core::ptr::with_exposed_provenance_mut::<u32>(address as usize).write_volatile(half)
                };
                address += 4;
            }
            unlocked.done().await?;
        }
        Ok(())
    }
}

impl Medium for Pages {
    async fn is_torn(&mut self, offset: u32) -> Result<bool, Refused> {
        Ok(Self::read_word(Self::address(offset, 8)?).1)
    }
}

/// The crystal stopped; or a double error in the flash: a torn preset, or a corrupt program.
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() {
    if pac::RCC.cifr().read().cssf() {
        restart(FaultKind::Clock);
    }
    let error = pac::FLASH.eccr().read();
    if error.eccd() {
        let pages = (BASE - BANK_2)..(BASE - BANK_2 + PAGE * PAGES);
        if !error.bk_ecc() || error.sysf_ecc() || !pages.contains(&error.addr_ecc()) {
            restart(FaultKind::Crash);
        }
        pac::FLASH.eccr().modify(|w| w.set_eccd(true)); // written 1: cleared
        TORN.store(true, Relaxed);
    }
}
