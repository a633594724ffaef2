//! The items of the presets in a flash whose power is cut in the middle of any operation.
#![cfg(not(target_os = "none"))]

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use emulator::random::Random;
use std::collections::{BTreeMap, BTreeSet};
use tribos_firmware::board::simulated::flash::{BYTES, PAGE, SimulatedFlash};
use tribos_firmware::presets::{Library, Medium, NotStored, Refused};

/// A flash as bad as it can be: an operation cut short leaves any of the bits undone, and a double word with a wrong
/// error-correcting code reads differently every time.
#[derive(Clone)]
struct Cut {
    bytes: Vec<u8>,
    torn: BTreeSet<usize>,
    random: Random,
    /// Operations that still have power.
    left: u64,
    done: u64,
    erasures: u64,
}

impl Cut {
    fn new(seed: u64) -> Self {
        let (bytes, torn) = (vec![0xff; BYTES], BTreeSet::new());
        Self { bytes, torn, random: Random(seed), left: u64::MAX, done: 0, erasures: 0 }
    }

    /// Power is back, for so many operations.
    fn powered(&self, operations: u64, seed: u64) -> Self {
        Self { left: operations, done: 0, erasures: 0, random: Random(seed), ..self.clone() }
    }

    /// How far an operation gets that is cut: chance of each bit, of 256. Not at all and all the way are among them.
    fn progress(&mut self, cut: bool) -> u64 {
        match (cut, self.random.below(4)) {
            (false, _) | (true, 0) => 256,
            (true, 1) => 0,
            (true, _) => self.random.draw() % 257,
        }
    }

    /// Begins an operation: true if it is the one that is cut.
    fn begin(&mut self) -> Result<bool, Refused> {
        let Some(left) = self.left.checked_sub(1) else { return Err(Refused) };
        self.left = left;
        self.done += 1;
        Ok(left == 0)
    }
}

impl ErrorType for Cut {
    type Error = Refused;
}

impl ReadNorFlash for Cut {
    const READ_SIZE: usize = 8;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        for (at, byte) in (offset as usize..).zip(bytes) {
            *byte = self.bytes[at];
            if self.torn.contains(&(at / 8)) {
                *byte ^= self.random.bits(64);
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        BYTES
    }
}

impl NorFlash for Cut {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = PAGE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        for page in from as usize / PAGE..to as usize / PAGE {
            let cut = self.begin()?;
            self.erasures += 1;
            let chance = self.progress(cut);
            for at in page * PAGE..(page + 1) * PAGE {
                let (before, erased) = (self.bytes[at], self.random.bits(chance));
                self.bytes[at] |= erased;
                let word = at / 8;
                if chance == 256 {
                    self.torn.remove(&word);
                } else if self.bytes[at] != before {
                    self.torn.insert(word);
                }
            }
            if cut {
                return Err(Refused);
            }
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        for (word, new) in (offset as usize / 8..).zip(bytes.chunks_exact(8)) {
            let held = 8 * word..8 * word + 8;
            let erased =
                self.bytes[held.clone()].iter().all(|byte| *byte == 0xff) && !self.torn.contains(&word);
            assert!(erased || new.iter().all(|byte| *byte == 0), "programmed twice at {:#x}", 8 * word);
            let cut = self.begin()?;
            let chance = self.progress(cut);
            for (at, byte) in held.zip(new) {
                self.bytes[at] &= byte | !self.random.bits(chance);
            }
            self.torn.remove(&word);
            if cut {
                if (1..256).contains(&chance) {
                    self.torn.insert(word);
                }
                return Err(Refused);
            }
        }
        Ok(())
    }
}

impl Medium for Cut {
    async fn is_torn(&mut self, offset: u32) -> Result<bool, Refused> {
        Ok(self.torn.contains(&(offset as usize / 8)))
    }
}

type Items = BTreeMap<u8, Vec<u8>>;

/// Power comes back: what the flash holds.
fn items(library: Library<Cut>) -> (Library<Cut>, Items) {
    let mut items = Items::new();
    let flash = library.close().powered(u64::MAX, 5);
    let mut each = |key, item: &[u8]| drop(items.insert(key, item.to_vec()));
    let library = block_on(Library::open(flash, &mut each)).expect("it can be read");
    (library, items)
}

fn open<F: Medium>(flash: F) -> Result<Library<F>, NotStored> {
    block_on(Library::open(flash, &mut |_, _| {}))
}

/// Of so many saves, power is cut at every operation of those that erase a page and of every 20th, and then once more
/// at a random operation of the repair. Returns operations, old sets and new sets found.
fn cut_everywhere(seed: u64, saves: usize) -> (u64, u64, u64) {
    let mut random = Random(seed);
    let mut library = open(Cut::new(seed)).expect("an erased flash");
    let mut known = Items::new();
    let (mut operations, mut old, mut new) = (0, 0, 0);
    for save in 0..saves {
        // most are seldom saved: they have to be copied on when their page is erased
        let key = if save < 9 || random.below(40) == 0 { random.below(9) } else { 8 } as u8;
        let item: Vec<u8> = (0..1 + random.below(200)).map(|_| random.draw() as u8).collect();
        let before = library.close();
        let mut after = known.clone();
        after.insert(key, item.clone());
        let mut whole = open(before.powered(u64::MAX, 0)).expect("nothing to repair");
        block_on(whole.store(key, &item)).expect("room");
        let erases = whole.close().erasures > 0;
        let cuts = if erases || save % 20 == 0 { u64::MAX } else { 0 };
        for cut in 0..cuts {
            // each operation torn in several ways
            let n = 1 + cut / 4;
            let tearing = random.draw();
            let mut torn = open(before.powered(n, tearing)).expect("nothing to repair");
            let whole = block_on(torn.store(key, &item));
            let mut flash = torn.close();
            if whole.is_ok() && flash.left > 0 {
                break;
            }
            operations += 1;
            // the repair is cut as well, sometimes more than once
            while random.below(3) > 0 {
                let left = 1 + random.below(12) as u64;
                flash = match open(flash.powered(left, random.draw())) {
                    Ok(library) => library.close(),
                    // the library took the flash with it: repair a copy to see what was left of it
                    Err(_) => repaired_in_part(&flash, left, random.draw()),
                };
            }
            let again = open(flash.powered(u64::MAX, random.draw())).expect("power is back");
            let (mut again, found) = items(again);
            assert!(found == known || found == after, "seed {seed}, cut {n}: neither old nor new");
            *(if found == after { &mut new } else { &mut old }) += 1;
            // and it goes on from there
            block_on(again.store(key, &item)).expect("it can be saved now");
            assert_eq!(items(again).1, after, "seed {seed}, cut {n}, saved again");
        }
        library = open(before.powered(u64::MAX, random.draw())).expect("power is back");
        block_on(library.store(key, &item)).expect("room");
        known = after;
        let found;
        (library, found) = items(library);
        assert_eq!(found, known);
    }
    (operations, old, new)
}

/// What a repair leaves that is cut after so many operations.
fn repaired_in_part(flash: &Cut, left: u64, seed: u64) -> Cut {
    let mut flash = flash.powered(left, seed);
    let mut journaled = tribos_firmware::presets::Journaled::new(&mut flash);
    assert!(block_on(journaled.recover()).is_err());
    flash
}

impl Medium for &mut Cut {
    async fn is_torn(&mut self, offset: u32) -> Result<bool, Refused> {
        (**self).is_torn(offset).await
    }
}

#[test]
fn power_cuts_leave_old_or_new_items() {
    println!("seed  saves  operations cut  old found  new found");
    for seed in 1..=2 {
        let saves = 400;
        let (operations, old, new) = cut_everywhere(seed, saves);
        println!("{seed:4}  {saves:5}  {operations:14}  {old:9}  {new:9}");
        assert_eq!(operations, old + new);
        assert!(operations > 2_000 && old > 1_000 && new > 20);
    }
}

#[test]
fn pages_wear_evenly() {
    let mut library = open(Cut::new(1)).expect("an erased flash");
    for save in 0..8_000_u32 {
        block_on(library.store((save % 9) as u8, &[save as u8; 250])).expect("room");
    }
    let flash = library.close();
    println!("8000 saves of 250 bytes: {} operations", flash.done);
    let (again, found) = items(open(flash).expect("nothing to repair"));
    assert_eq!((found.len(), &found[&((7_999 % 9) as u8)]), (9, &vec![7_999_u32 as u8; 250]));
    assert_eq!(again.close().done, 0, "nothing was to be repaired");
}

#[test]
fn a_failed_flash_keeps_its_contents() {
    let mut library = open(Cut::new(1)).expect("an erased flash");
    block_on(library.store(1, b"kept")).expect("room");
    let mut dead = open(library.close().powered(0, 1)).expect("nothing to repair");
    assert_eq!(block_on(dead.store(2, b"lost")), Err(NotStored::Refused));
    assert_eq!(items(dead).1, Items::from([(1, b"kept".to_vec())]));
}

#[test]
fn garbage_in_flash_causes_no_panic() {
    let mut random = Random(7);
    let (mut taken, mut refused) = (0, 0);
    for round in 0..300 {
        let mut bytes: Vec<u8> = (0..BYTES).map(|_| random.draw() as u8).collect();
        for page in bytes.chunks_mut(PAGE) {
            if random.below(2) == 0 {
                page.fill(if random.below(2) == 0 { 0xff } else { 0 });
            }
        }
        let opened = open(SimulatedFlash::of(&bytes));
        let stored = opened.and_then(|mut library| block_on(library.store(3, &[round as u8; 40])));
        *(if stored.is_ok() { &mut taken } else { &mut refused }) += 1;
    }
    println!("garbage: {taken} saved over, {refused} refused");
    assert_eq!(taken + refused, 300);
}
