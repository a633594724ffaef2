//! Cycles that the core waits for memories and buses, which the interpreter does not count.
//!
//! | access | wait |
//! | --- | --- |
//! | fetch from flash | none within the 64 bits last read, none in the instruction cache; what remains of a prefetch; else the wait states of FLASH_ACR |
//! | load from flash | none in the data cache, else the wait states |
//! | fetch from CCM SRAM | none |
//! | load of a literal from CCM SRAM | 1: code and literals share its only port |
//! | SRAM1, SRAM2 | none |
//! | APB peripheral | 3 for a load, 1 for a store: the bridge takes a setup and an access phase, and buffers one store |
//! | AHB peripheral | 1 for a load |
//!
//! The caches are those of [rm0440, "Adaptive real-time memory accelerator"]: 1 KiB for code and 256 B for data, in entries of
//! 64 bits that are replaced in the order of their use. The core's own fetch of three words ahead is not modelled: it waits for
//! each line as a core without one, so that flash is never better here than on the chip.

use rsemu::cpu::arm::v7m::isa::is_32bit;

/// Bytes that the flash reads at once in dual-bank mode.
const LINE: u32 = 8;
/// Entries of the instruction cache and of the data cache.
const CODE_LINES: usize = 128;
const DATA_LINES: usize = 32;

/// Fields of FLASH_ACR.
const PRFTEN: u32 = 1 << 8;
const ICEN: u32 = 1 << 9;
const DCEN: u32 = 1 << 10;

/// Wait of a load from a peripheral at this address, and of a store.
pub(crate) fn bus(address: u32) -> (u64, u64) {
    match address {
        0x4000_0000..0x4002_0000 => (3, 1),
        _ => (1, 0),
    }
}

/// Lines with the time of their last use.
#[derive(Debug)]
struct Cache<const N: usize> {
    lines: [(u32, u64); N],
    uses: u64,
}

impl<const N: usize> Cache<N> {
    fn new() -> Self {
        Self { lines: [(u32::MAX, 0); N], uses: 0 }
    }

    /// Whether the line is there; it is from then on.
    fn take(&mut self, line: u32) -> bool {
        self.uses += 1;
        // a line has a home among four places, so that a search does not take long
        let home = line as usize % (N / 4);
        let places = &mut self.lines[4 * home..4 * home + 4];
        let hit = places.iter().position(|(held, _)| *held == line);
        let oldest = || places.iter().enumerate().min_by_key(|(_, (_, used))| *used).map_or(0, |(k, _)| k);
        let place = hit.unwrap_or_else(oldest);
        places[place] = (line, self.uses);
        hit.is_some()
    }
}

/// Wait states of FLASH_ACR.
fn states(acr: u32) -> u64 {
    u64::from(acr & 0xf)
}

/// What the flash interface does for instructions.
#[derive(Debug)]
pub(crate) struct Waits {
    acr: u32,
    code: Cache<CODE_LINES>,
    /// Line that the core reads from.
    current: u32,
    /// Line being read ahead, and the cycle at which it is there.
    ahead: (u32, u64),
}

impl Waits {
    pub fn new() -> Self {
        Self { acr: 0, code: Cache::new(), current: u32::MAX, ahead: (u32::MAX, 0) }
    }

    /// Settings of FLASH_ACR; whether they are others.
    pub fn set(&mut self, acr: u32) -> bool {
        std::mem::replace(&mut self.acr, acr) != acr
    }

    /// Wait for an instruction of `bytes` in flash, at this cycle.
    #[inline]
    pub fn fetch(&mut self, address: u32, bytes: u32, cycle: u64) -> u64 {
        let (first, last) = (address / LINE, (address + bytes - 1) / LINE);
        if first == self.current && last == self.current { 0 } else { self.lines(first, last, cycle) }
    }

    fn lines(&mut self, first: u32, last: u32, cycle: u64) -> u64 {
        let mut wait = 0;
        for line in [first, last] {
            if line != self.current {
                self.current = line;
                wait += self.line(line, cycle + wait);
            }
        }
        wait
    }

    fn line(&mut self, line: u32, cycle: u64) -> u64 {
        let cached = self.acr & ICEN != 0 && self.code.take(line);
        let wait = match self.ahead {
            _ if cached => 0,
            (ahead, at) if ahead == line => at.saturating_sub(cycle),
            _ => states(self.acr),
        };
        if self.acr & PRFTEN != 0 && !cached {
            self.ahead = (line + 1, cycle + wait + states(self.acr) + 1);
        }
        wait
    }
}

/// What the flash interface does for loads.
#[derive(Debug)]
pub(crate) struct Literals {
    acr: u32,
    data: Cache<DATA_LINES>,
}

impl Literals {
    pub fn new() -> Self {
        Self { acr: 0, data: Cache::new() }
    }

    /// Settings of FLASH_ACR.
    pub fn set(&mut self, acr: u32) {
        self.acr = acr;
    }

    /// Wait for a load from flash.
    pub fn load(&mut self, address: u32) -> u64 {
        if self.acr & DCEN != 0 && self.data.take(address / LINE) { 0 } else { states(self.acr) }
    }
}

/// What the fetch of an instruction takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Fetch {
    pub bytes: u32,
    /// It loads from its own code: `ldr` and `vldr` of a literal, and the tables of `tbb` and `tbh`.
    pub literal: bool,
}

impl Fetch {
    /// Of an instruction with this first half-word.
    pub fn of(first: u16) -> Self {
        let literal = first >> 11 == 0b01001
            || matches!(first, 0xf85f | 0xf8df | 0xed1f | 0xed9f | 0xed5f | 0xeddf | 0xe8df);
        Self { bytes: if is_32bit(first) { 4 } else { 2 }, literal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_170_mhz(flags: u32) -> Waits {
        let mut waits = Waits::new();
        waits.set(4 | flags);
        waits
    }

    /// Waits of a straight run of 16 instructions of 4 bytes, a cycle each.
    fn run(waits: &mut Waits, mut cycle: u64) -> u64 {
        let mut sum = 0;
        for k in 0..16 {
            let wait = waits.fetch(0x0800_1000 + 4 * k, 4, cycle);
            sum += wait;
            cycle += 1 + wait;
        }
        sum
    }

    #[test]
    fn sequential_code_waits_for_each_line_less_with_prefetch_and_never_from_the_cache() {
        assert_eq!(run(&mut at_170_mhz(0), 0), 8 * 4);
        // a line is read while the two instructions of the one before run
        assert_eq!(run(&mut at_170_mhz(PRFTEN), 0), 4 + 7 * 3);
        let mut waits = at_170_mhz(ICEN | PRFTEN);
        assert_eq!(run(&mut waits, 0), 4 + 7 * 3);
        assert_eq!(run(&mut waits, 1_000), 0);
    }

    #[test]
    fn the_cache_holds_a_kibibyte() {
        let mut waits = at_170_mhz(ICEN);
        for pass in 0..3 {
            let waited: u64 = (0..128).map(|line| waits.fetch(0x0800_0000 + 8 * line, 4, 0)).sum();
            assert_eq!(waited, if pass == 0 { 128 * 4 } else { 0 });
        }
        let waited: u64 = (0..256).map(|line| waits.fetch(0x0801_0000 + 8 * line, 4, 0)).sum();
        assert_eq!(waited, 256 * 4);
        let waited: u64 = (0..128).map(|line| waits.fetch(0x0800_0000 + 8 * line, 4, 0)).sum();
        assert_eq!(waited, 128 * 4, "evicted");
    }

    #[test]
    fn an_instruction_over_two_lines_waits_for_both() {
        assert_eq!(at_170_mhz(0).fetch(0x0800_0006, 4, 0), 8);
        assert_eq!(at_170_mhz(0).fetch(0x0800_0006, 2, 0), 4);
    }

    #[test]
    fn loads_go_through_the_data_cache() {
        let mut literals = Literals::new();
        literals.set(4 | DCEN);
        assert_eq!([0x0800_0000, 0x0800_0004, 0x0800_0008].map(|at| literals.load(at)), [4, 0, 4]);
        literals.set(4);
        assert_eq!([0, 0].map(|at| literals.load(at)), [4, 4]);
    }
}
