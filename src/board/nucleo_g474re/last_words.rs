//! Why the firmware restarted itself, kept over the reset in RAM that nothing initialises.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use haptics::FaultKind;

/// In the upper bits of a word that means something; after power-on there is anything.
const MARK: u32 = 0x7b1b_0500;

#[repr(transparent)]
struct Kept(UnsafeCell<MaybeUninit<u32>>);

// SAFETY: a word, read and written whole by volatile accesses; the last writer is the one that counts.
unsafe impl Sync for Kept {}

#[unsafe(link_section = ".uninit.last_words")]
static WORD: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

fn read() -> u32 {
    // SAFETY: any bits are a u32, and the access is volatile: the compiler assumes nothing of what is there.
    unsafe { WORD.0.get().cast::<u32>().read_volatile() }
}

fn write(word: u32) {
    // SAFETY: valid and aligned for ever.
    unsafe { WORD.0.get().cast::<u32>().write_volatile(word) };
}

fn kept() -> Option<FaultKind> {
    let word = read();
    FaultKind::from_code((word ^ MARK) as u8).filter(|_| word & !0xff == MARK)
}

/// Keeps a reason for the next start. The first one stays: what follows is its consequence.
pub(super) fn keep(kind: FaultKind) {
    if kept().is_none() {
        write(MARK ^ u32::from(kind.code()));
    }
}

/// The danger is over.
pub(super) fn forget() {
    write(0);
}

/// The reason that was kept, if there is one; it is told once.
pub(super) fn take() -> Option<FaultKind> {
    let kind = kept();
    forget();
    kind
}
