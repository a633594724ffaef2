//! The flash controller in dual-bank mode [rm0440, "Embedded flash memory"], and bank 2 with its error-correcting
//! code.
//!
//! The code is in bank 1, which is read-only here: erasing or programming it is a violation. Bank 2 is an array of double
//! words that is erased by page. Power can be cut at the n-th erasure or programming ([`Flash::cut_at`]). That operation then
//! changes only some of the bits and leaves a wrong code; reading gives random bits and raises the NMI.

use crate::UNITS_PER_SECOND;
use crate::random::Random;
use std::collections::BTreeSet;

/// First address of bank 2.
pub(crate) const BANK_2: u32 = 0x0804_0000;
/// Bytes of a bank.
pub(crate) const BANK_BYTES: u32 = 256 * 1024;
const PAGE: usize = 2048;

/// Longest times for a double word and for a page of 2 KiB [ds12288, table of flash characteristics, 2024].
const PROGRAM: u64 = UNITS_PER_SECOND / 1_000_000 * 84;
const ERASE: u64 = UNITS_PER_SECOND / 1_000_000 * 24_470;

const ACR: u32 = 0x00;
const KEYR: u32 = 0x08;
const SR: u32 = 0x10;
const CR: u32 = 0x14;
const ECCR: u32 = 0x18;
const OPTR: u32 = 0x20;

const ACR_DCEN: u32 = 1 << 10;
const ACR_DCRST: u32 = 1 << 12;
const CR_PG: u32 = 1;
const CR_PER: u32 = 1 << 1;
const CR_BKER: u32 = 1 << 11;
const CR_STRT: u32 = 1 << 16;
const CR_LOCK: u32 = 1 << 31;
const SR_PROGERR: u32 = 1 << 3;
const SR_PGAERR: u32 = 1 << 5;
const SR_SIZERR: u32 = 1 << 6;
const SR_PGSERR: u32 = 1 << 7;
const SR_BSY: u32 = 1 << 16;
const SR_FLAGS: u32 = 0xc3fb;
const SR_ERRORS: u32 = SR_FLAGS & !1;
const ECCR_ECCD: u32 = 1 << 31;
const ECCR_BK_ECC: u32 = 1 << 21;
/// Factory setting: two banks.
const OPTR_RESET: u32 = 0xffef_f8aa;
const OPTR_DBANK: u32 = 1 << 22;
/// Place of BOR_LEV.
const OPTR_BOR: u32 = 8;

/// Result of an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Whole,
    /// Power was cut: each bit changes with this chance of 256.
    Cut(u64),
}

#[derive(Debug)]
pub(crate) struct Flash {
    acr: u32,
    sr: u32,
    cr: u32,
    eccr: u32,
    optr: u32,
    /// Number of correct keys. `None` after a wrong one, until the reset.
    keys: Option<u8>,
    busy_until: u64,
    /// First half of a double word, with its offset.
    half: Option<(u32, u32)>,
    bank_2: Vec<u8>,
    torn: BTreeSet<u32>,
    random: Random,
    /// Number of erasures and programmings since power-on, and the one at which power is cut.
    operations: u64,
    cut_at: Option<u64>,
    /// Whether power was cut.
    pub power_lost: bool,
    /// Whether an NMI is pending.
    pub nmi: bool,
    pub violation: Option<String>,
}

impl Flash {
    pub fn new() -> Self {
        Self {
            acr: 0x0004_0600,
            sr: 0,
            cr: 0xc000_0000,
            eccr: 0,
            optr: OPTR_RESET,
            keys: Some(0),
            busy_until: 0,
            half: None,
            bank_2: vec![0xff; BANK_BYTES as usize],
            torn: BTreeSet::new(),
            random: Random(1),
            operations: 0,
            cut_at: None,
            power_lost: false,
            nmi: false,
            violation: None,
        }
    }

    /// Resets the registers. Contents remain.
    pub fn reset(&mut self, now: u64) {
        if now < self.busy_until {
            self.violates("reset while the flash was erased or programmed");
        }
        let fresh = Self::new();
        (self.acr, self.sr, self.cr, self.eccr) = (fresh.acr, fresh.sr, fresh.cr, fresh.eccr);
        (self.keys, self.busy_until, self.half, self.nmi) = (fresh.keys, 0, None, false);
    }

    /// Sets the option byte of two banks.
    pub fn set_brown_out_level(&mut self, level: u32) {
        self.optr = self.optr & !(7 << OPTR_BOR) | level << OPTR_BOR;
    }

    pub fn set_dual_bank(&mut self, dual: bool) {
        self.optr = if dual { self.optr | OPTR_DBANK } else { self.optr & !OPTR_DBANK };
    }

    /// Cuts power at the n-th erasure or programming from now, which is half done, depending on `seed`.
    pub fn cut_at(&mut self, n: Option<u64>, seed: u64) {
        (self.operations, self.cut_at, self.random) = (0, n, Random(seed));
    }

    /// Number of erasures and programmings since the last [`Self::cut_at`] or power-on.
    pub fn operations(&self) -> u64 {
        self.operations
    }

    /// Restores power.
    pub fn power_up(&mut self) {
        self.busy_until = 0;
        self.power_lost = false;
        self.cut_at = None;
        self.reset(0);
    }

    /// Contents of bank 2 from an offset on.
    pub fn contents(&self, offset: u32) -> &[u8] {
        self.bank_2.get(offset as usize..).unwrap_or(&[])
    }

    /// Writes like a programmer.
    pub fn load(&mut self, offset: u32, bytes: &[u8]) {
        for (at, byte) in (offset as usize..).zip(bytes) {
            if let Some(to) = self.bank_2.get_mut(at) {
                *to = *byte;
                self.torn.remove(&(at as u32 / 8));
            }
        }
    }

    /// The register of wait states, caches and prefetch.
    pub fn acr(&self) -> u32 {
        self.acr
    }

    pub fn wait_states(&self) -> u64 {
        u64::from(self.acr & 0xf)
    }

    fn violates(&mut self, what: &str) {
        self.violation.get_or_insert_with(|| format!("flash: {what}"));
    }

    fn busy(&self, now: u64) -> bool {
        now < self.busy_until
    }

    pub fn read(&self, offset: u32, now: u64) -> u32 {
        match offset {
            ACR => self.acr,
            SR => self.sr | if self.busy(now) { SR_BSY } else { 0 },
            CR => self.cr,
            ECCR => self.eccr,
            OPTR => self.optr,
            _ => 0,
        }
    }

    pub fn write(&mut self, offset: u32, value: u32, now: u64) {
        match offset {
            ACR => {
                if value & ACR_DCRST != 0 && self.acr & ACR_DCEN != 0 {
                    self.violates("data cache reset while it is on");
                }
                self.acr = value;
            }
            KEYR => self.key(value),
            SR => self.sr &= !(value & SR_FLAGS),
            // written 1, the flags of the code are cleared
            ECCR => self.eccr &= !(value & 0xf000_0000),
            CR if self.cr & CR_LOCK != 0 => self.violates("control register written while it is locked"),
            CR if self.busy(now) => self.violates("control register written while the flash is busy"),
            CR => {
                self.cr = value & !CR_STRT;
                if value & CR_STRT != 0 {
                    self.start(now);
                }
                if value & CR_LOCK != 0 {
                    self.keys = self.keys.map(|_| 0);
                }
            }
            _ => {}
        }
    }

    fn key(&mut self, value: u32) {
        self.keys = match (self.keys, value) {
            (Some(0), 0x4567_0123) => Some(1),
            (Some(1), 0xcdef_89ab) => {
                self.cr &= !CR_LOCK;
                Some(2)
            }
            _ => {
                self.violates("wrong key: locked until the reset");
                self.cr |= CR_LOCK;
                None
            }
        };
    }

    /// An operation begins.
    fn begin(&mut self, duration: u64, now: u64) -> Outcome {
        if self.optr & OPTR_DBANK == 0 {
            self.violates("erased or programmed as a single bank, which stalls the core");
        }
        if self.acr & ACR_DCEN != 0 {
            self.violates("erased or programmed with the data cache on (ES0430, read while write)");
        }
        self.operations += 1;
        self.busy_until = now + duration;
        if self.cut_at != Some(self.operations) {
            return Outcome::Whole;
        }
        self.power_lost = true;
        // barely started and nearly done are the interesting cases
        Outcome::Cut(match self.random.draw() % 4 {
            0 => 256,
            1 => 0,
            _ => self.random.draw() % 257,
        })
    }

    fn start(&mut self, now: u64) {
        if self.sr & SR_ERRORS != 0 || self.cr & (CR_PER | CR_PG) != CR_PER {
            self.sr |= SR_PGSERR;
            return;
        }
        if self.cr & CR_BKER == 0 {
            return self.violates("a page of bank 1 erased, from where the code runs");
        }
        let outcome = self.begin(ERASE, now);
        let from = (self.cr >> 3 & 0x7f) as usize * PAGE;
        for at in from..from + PAGE {
            let erased = match outcome {
                Outcome::Whole => 0xff,
                Outcome::Cut(chance) => self.random.bits(chance),
            };
            let before = self.bank_2[at];
            self.bank_2[at] |= erased;
            let word = at as u32 / 8;
            if matches!(outcome, Outcome::Whole | Outcome::Cut(256)) {
                self.torn.remove(&word);
            } else if self.bank_2[at] != before {
                self.torn.insert(word);
            }
        }
    }

    /// A store into the array.
    pub fn store(&mut self, offset: u32, bytes: &[u8], now: u64) {
        if self.busy(now) {
            return self.violates("stored to while it is busy");
        }
        let sequence = self.sr & SR_ERRORS != 0 || self.cr & (CR_LOCK | CR_PG | CR_PER) != CR_PG;
        let Ok(word) = bytes.try_into().map(u32::from_le_bytes) else {
            self.sr |= SR_SIZERR;
            return;
        };
        if sequence {
            self.sr |= SR_PGSERR;
            return;
        }
        match self.half.take() {
            None if offset.is_multiple_of(8) => self.half = Some((offset, word)),
            Some((first, low)) if offset == first + 4 => {
                self.program(first as usize, u64::from(low) | u64::from(word) << 32, now);
            }
            _ => self.sr |= SR_PGAERR,
        }
    }

    fn program(&mut self, at: usize, new: u64, now: u64) {
        let word = at as u32 / 8;
        let held = &self.bank_2[at..at + 8];
        let erased = held.iter().all(|byte| *byte == 0xff) && !self.torn.contains(&word);
        // zeros can be written over anything
        if !erased && new != 0 {
            self.sr |= SR_PROGERR;
            return;
        }
        let outcome = self.begin(PROGRAM, now);
        for (at, byte) in (at..).zip(new.to_le_bytes()) {
            self.bank_2[at] &= match outcome {
                Outcome::Whole => byte,
                Outcome::Cut(chance) => byte | !self.random.bits(chance),
            };
        }
        match outcome {
            Outcome::Cut(1..256) => self.torn.insert(word),
            // nothing happened yet
            Outcome::Cut(0) => false,
            _ => self.torn.remove(&word),
        };
    }

    /// A load from the array.
    pub fn fetch(&mut self, offset: u32, bytes: &mut [u8], now: u64) {
        if self.busy(now) {
            self.violates("bank 2 read while it is busy: the core stalls");
        }
        let torn = self.torn.contains(&(offset / 8));
        for (at, byte) in (offset as usize..).zip(bytes) {
            *byte = self.bank_2.get(at).copied().unwrap_or(0xff);
            if torn {
                *byte ^= self.random.bits(64);
            }
        }
        if torn {
            // the address of the first one stays until it is cleared
            if self.eccr & ECCR_ECCD == 0 {
                self.eccr = ECCR_ECCD | ECCR_BK_ECC | (offset & !7);
            }
            self.nmi = true;
        }
    }
}

#[cfg(test)]
#[path = "flash_tests.rs"]
mod tests;
