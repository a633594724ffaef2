//! Black box: the first fault with its motion, kept over a reset in uninitialised RAM.
//!
//! Each control step writes its motion until a fault is latched. A panic, a crash or the watchdog also ends that: the previous
//! step is their record. A fault that is not cleared is not overwritten.

use crate::app::{Earlier, FaultReport};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::panic::Location;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use haptics::{FaultKind, ModeId, Outputs};

const MARK: u32 = 0x7b1b_0b0c;
/// Words: check, kind (0: none), step, mode, position, velocity, force, line (0: no panic), program counter (0: no crash), return
/// address and CFSR of a crash, then the end of the path.
const WORDS: usize = 11 + PATH / 4;
const CHECK: usize = 0;
const KIND: usize = 1;
const STEP: usize = 2;
const MODE: usize = 3;
const POSITION: usize = 4;
const VELOCITY: usize = 5;
const FORCE: usize = 6;
const LINE: usize = 7;
const PC: usize = 8;
const LR: usize = 9;
const CFSR: usize = 10;
/// Bytes of the path of a panic.
const PATH: usize = 40;

#[repr(transparent)]
struct Kept(UnsafeCell<MaybeUninit<[u32; WORDS]>>);

// SAFETY: words, accessed whole and volatile; a wrong check sum reveals a mixture.
unsafe impl Sync for Kept {}

#[unsafe(link_section = ".uninit.black_box")]
static BOX: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));
/// Whether the fault is from before the last reset.
static EARLIER: AtomicBool = AtomicBool::new(false);

fn get(at: usize) -> u32 {
    // SAFETY: any bits are a u32; `at` is below WORDS, and the access is volatile.
    unsafe { BOX.0.get().cast::<u32>().add(at % WORDS).read_volatile() }
}

fn set(at: usize, word: u32) {
    // SAFETY: as above.
    unsafe { BOX.0.get().cast::<u32>().add(at % WORDS).write_volatile(word) };
}

fn check() -> u32 {
    (KIND..=CFSR).fold(MARK, |sum, at| sum ^ get(at))
}

/// Restores the record at the start. `cause` is the reason of an unexpected reset.
pub(super) fn open(cause: Option<FaultKind>) {
    let valid = get(CHECK) == check();
    match (valid, get(KIND), cause) {
        (true, 0, Some(kind)) => set(KIND, kind.code().into()),
        (true, 1.., _) => {}
        _ => (0..WORDS).for_each(|at| set(at, 0)),
    }
    EARLIER.store(get(KIND) != 0, Relaxed);
    set(CHECK, check());
}

/// Records one control step: its motion, or its fault.
#[inline]
pub(super) fn note(step: u32, outputs: &Outputs) {
    if get(KIND) != 0 {
        return;
    }
    let (position, velocity) = (outputs.position.to_bits(), outputs.velocity.to_bits());
    set(STEP, step);
    set(POSITION, position);
    set(VELOCITY, velocity);
    if let Some(kind) = outputs.fault {
        // mode and force are those of the previous step
        set(KIND, kind.code().into());
        set(CHECK, check());
        return;
    }
    let (mode, force) = (u32::from(outputs.mode.code()), outputs.force.to_bits());
    set(MODE, mode);
    set(FORCE, force);
    set(CHECK, MARK ^ step ^ position ^ velocity ^ mode ^ force);
}

/// Records that the firmware restarts itself.
pub(super) fn keep(kind: FaultKind) {
    if get(KIND) == 0 {
        set(KIND, kind.code().into());
        set(CHECK, check());
    }
}

/// Records the place of a panic, if it is the first fault.
pub fn panicked_at(place: &Location<'_>) {
    if get(KIND) != 0 {
        return;
    }
    let path = place.file().as_bytes();
    let end = path.get(path.len().saturating_sub(PATH)..).unwrap_or(path);
    for (at, word) in (CFSR + 1..WORDS).enumerate() {
        let byte = |k: usize| u32::from(end.get(4 * at + k).copied().unwrap_or(0)) << (8 * k);
        set(word, byte(0) | byte(1) | byte(2) | byte(3));
    }
    set(LINE, place.line().max(1));
}

/// Records where the processor crashed, if that is the first fault, and its configurable fault status [armv7-m, ch. B3.2.15].
pub(super) fn crashed_at(pc: u32, lr: u32, cfsr: u32) {
    if get(KIND) == 0 {
        set(PC, pc.max(1));
        set(LR, lr);
        set(CFSR, cfsr);
    }
}

/// Clears the fault. The next control step corrects the check sum.
pub(super) fn forget() {
    EARLIER.store(false, Relaxed);
    (LINE..=CFSR).for_each(|at| set(at, 0));
    set(KIND, 0);
}

/// The fault from before the last reset.
pub(super) fn earlier() -> Option<Earlier> {
    let kind = FaultKind::from_code(get(KIND) as u8).filter(|_| EARLIER.load(Relaxed))?;
    let number = |at| f32::from_bits(get(at));
    let mut path = heapless::String::new();
    for word in CFSR + 1..WORDS {
        for byte in get(word).to_le_bytes().into_iter().filter(u8::is_ascii_graphic) {
            let _ = path.push(char::from(byte));
        }
    }
    Some(Earlier {
        fault: FaultReport {
            kind,
            step: get(STEP),
            during: ModeId::from_code(get(MODE) as u8).unwrap_or_default(),
            position: number(POSITION),
            velocity: number(VELOCITY),
            force: number(FORCE),
        },
        panicked_at: (get(LINE) != 0).then(|| (path, get(LINE))),
        crashed_at: (get(PC) != 0).then(|| [get(PC), get(LR), get(CFSR)]),
    })
}
