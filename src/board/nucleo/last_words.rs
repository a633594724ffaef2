//! Reason of a restart by the firmware, kept over the reset in uninitialised RAM.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use haptics::FaultKind;

/// Marks a valid word in its upper bits. After power-on the RAM is random.
const MARK: u32 = 0x7b1b_0500;

#[repr(transparent)]
struct Kept(UnsafeCell<MaybeUninit<u32>>);

// SAFETY: a word, accessed whole and volatile; the last writer wins.
unsafe impl Sync for Kept {}

#[unsafe(link_section = ".uninit.last_words")]
static WORD: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

fn read() -> u32 {
    // SAFETY: any bits are a u32, and the access is volatile: the compiler assumes nothing about them.
    unsafe { WORD.0.get().cast::<u32>().read_volatile() }
}

fn write(word: u32) {
    // SAFETY: always valid and aligned.
    unsafe { WORD.0.get().cast::<u32>().write_volatile(word) };
}

fn kept() -> Option<FaultKind> {
    let word = read();
    FaultKind::from_code((word ^ MARK) as u8).filter(|_| word & !0xff == MARK)
}

/// Keeps a reason for the next start. The first reason stays: later ones are its consequences.
pub(super) fn keep(kind: FaultKind) {
    if kept().is_none() {
        write(MARK ^ u32::from(kind.code()));
    }
}

/// Withdraws a reason.
pub(super) fn forget() {
    write(0);
}

/// The kept reason, if any; returned once.
pub(super) fn take() -> Option<FaultKind> {
    let kind = kept();
    forget();
    kind
}
