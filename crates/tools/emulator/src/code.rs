//! Decoded instructions of flash and of CCM SRAM.

use crate::flash::BANK_2;
use crate::image::{CCM_BASE, CCM_END, CCM_SIZE, FLASH_BASE};
use crate::wait::Fetch;
use rsemu::core::space::{RamStore, RomStore};
use rsemu::core::value::{Endian, Width};
use rsemu::cpu::arm::v7m::isa::{Insn, decode, is_32bit};

/// Bytes of CCM SRAM that are decoded again after a store, as a power of two.
const PAGE_BITS: u32 = 8;

/// CCM SRAM, which knows the pages that were written.
pub(crate) fn ccm_store() -> RamStore {
    RamStore::with_page_bits(u64::from(CCM_SIZE), PAGE_BITS)
}

/// A decoded instruction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Decoded {
    pub insn: Insn,
    pub fetch: Fetch,
}

/// Instructions that were executed before, by half-word.
#[derive(Debug)]
pub(crate) struct Code {
    flash: Vec<Option<Decoded>>,
    ccm: Vec<Option<Decoded>>,
}

impl Code {
    /// Of a flash with code in its first bytes.
    pub fn new(flash_bytes: u32) -> Self {
        Self { flash: vec![None; (flash_bytes / 2) as usize], ccm: vec![None; (CCM_SIZE / 2) as usize] }
    }

    /// The instruction at an address; none outside the code.
    #[inline]
    pub fn at(&mut self, pc: u32, bank_1: &RomStore, ccm: &RamStore) -> Option<Decoded> {
        let slot = self.slot(pc)?;
        if slot.is_none() {
            *slot = decoded(pc, bank_1, ccm);
        }
        *slot
    }

    #[inline]
    fn slot(&mut self, pc: u32) -> Option<&mut Option<Decoded>> {
        match pc {
            FLASH_BASE..BANK_2 => self.flash.get_mut(((pc - FLASH_BASE) / 2) as usize),
            CCM_BASE..CCM_END => self.ccm.get_mut(((pc - CCM_BASE) / 2) as usize),
            _ => None,
        }
    }

    /// Forgets the instructions that a store to these bytes of CCM SRAM changes.
    pub fn forget(&mut self, offset: u32, bytes: u32) {
        // one of 32 bits may begin a half-word before
        let (from, to) = ((offset / 2).saturating_sub(1) as usize, (offset + bytes).div_ceil(2) as usize);
        let to = to.min(self.ccm.len());
        self.ccm[from..to].fill(None);
    }

    /// Forgets the instructions of the pages written since the last call.
    pub fn forget_written(&mut self, ccm: &RamStore) {
        let mut any = false;
        ccm.for_each_dirty_page(|page| {
            any = true;
            self.forget((page as u32) << PAGE_BITS, 1 << PAGE_BITS);
        });
        if any {
            ccm.clear_dirty();
        }
    }
}

#[cold]
fn decoded(pc: u32, bank_1: &RomStore, ccm: &RamStore) -> Option<Decoded> {
    let half = |at: u32| {
        let half = match pc {
            FLASH_BASE..BANK_2 => bank_1.read_value(u64::from(at - FLASH_BASE), Width::U16, Endian::Little),
            _ => ccm.read_value(u64::from(at - CCM_BASE), Width::U16, Endian::Little),
        };
        half.ok().map(|half| half as u16)
    };
    let first = half(pc)?;
    // the second half may not be there
    let second = if is_32bit(first) { half(pc + 2)? } else { 0 };
    Some(Decoded { insn: decode(first, second), fetch: Fetch::of(first) })
}
