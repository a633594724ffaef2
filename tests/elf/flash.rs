//! Presets in the flash of the board, and power that goes in the middle of saving them.

use crate::board::Board;
use emulator::ResetCause;
use haptics::Settings;
use link::{Change, MAX_ITEM, PresetStore};
use tribos_firmware::board::simulated::flash::{BYTES, PAGE, SimulatedFlash};
use tribos_firmware::presets::Library;

/// KEYR of the flash controller: a wrong key locks it until the reset.
const FLASH_KEYR: u32 = 0x4002_2008;

fn settings(f_dynamic: f32) -> Settings {
    Settings { f_dynamic_p: f_dynamic, f_dynamic_n: f_dynamic, ..Settings::rubber() }
}

/// Presets as the firmware keeps them, made on the PC.
struct Shelf {
    store: PresetStore,
    library: Library<SimulatedFlash>,
}

impl Shelf {
    fn of(contents: &[u8]) -> Self {
        let mut store = PresetStore::new();
        let mut each = |key, item: &[u8]| store.load(key, item);
        let opened = Library::open(SimulatedFlash::of(contents), &mut each);
        Self { library: embassy_futures::block_on(opened).expect("a flash"), store }
    }

    fn keep(&mut self, change: Change) {
        let mut item = [0; MAX_ITEM];
        let stored = self.library.store(change.key(), change.encode(&mut item));
        embassy_futures::block_on(stored).expect("room");
        self.store.commit(change);
    }

    /// Two presets, the first one the default.
    fn usual() -> Self {
        let mut shelf = Self::of(&[]);
        for (name, force) in [("first", 1.5), ("second", 2.5)] {
            shelf.keep(shelf.store.save(name, &settings(force)).expect("room"));
        }
        shelf.keep(shelf.store.set_default("first").expect("it is saved"));
        shelf
    }

    fn contents(self) -> Vec<u8> {
        self.library.close().contents().to_vec()
    }

    /// Saved over and over until the next item needs a full page to be copied and erased.
    fn before_a_page_is_collected() -> Vec<u8> {
        let used = |bytes: &[u8]| bytes.chunks(PAGE).filter(|page| page.iter().any(|b| *b != 0xff)).count();
        let mut before = Self::usual().contents();
        for turn in 0.. {
            let mut shelf = Self::of(&before);
            let force = 1.6 + 0.001 * (turn % 500) as f32;
            shelf.keep(shelf.store.save("second", &settings(force)).expect("room"));
            let after = shelf.contents();
            // the journal is used only when a page is erased
            if used(&after[BYTES - PAGE..]) > 0 {
                break;
            }
            before = after;
        }
        before
    }
}

/// What a person sees of the presets.
fn seen(board: &mut Board) -> Vec<String> {
    let mut seen = vec![board.ok("preset list")];
    for name in ["first", "second", "third"] {
        seen.extend(board.ask(&format!("preset show {name}")));
    }
    seen
}

/// Types a command that is answered at its end, or not at all because power goes. True: power went.
fn goes_off_during(board: &mut Board, command: &str) -> bool {
    let before = board.machine.resets().len();
    board.lines.clear();
    board.machine.serial_write(format!("{command}\n").as_bytes());
    for _ in 0..6_000 {
        board.run(0.1);
        if board.machine.resets().len() > before {
            assert_eq!(board.machine.resets()[before].1, ResetCause::PowerOn);
            return true;
        }
        if let Some(line) = board.lines.first() {
            assert!(line.starts_with("ok"), "{command}: {line}");
            return false;
        }
    }
    panic!("`{command}` was not answered within 600 ms");
}

pub fn power_cuts_leave_old_or_new_presets() {
    let usual = Shelf::usual().contents();
    let mut journal_full = Shelf::before_a_page_is_collected();
    journal_full[BYTES - PAGE..].fill(0);
    println!("what is cut                                    operations   old   new");
    for (what, contents, command) in [
        ("preset save, replacing one", &usual, "preset save first"),
        ("preset save, a new one", &usual, "preset save third"),
        ("preset delete of the default preset", &usual, "preset delete first"),
        ("preset default", &usual, "preset default second"),
        ("preset save, a page and the journal erased", &journal_full, "preset save first"),
    ] {
        let mut board = Board::with_presets(contents);
        let old = seen(&mut board);
        board.ok("set f_dynamic 1.25");
        assert!(!goes_off_during(&mut board, command));
        let mut board = Board::with_presets(&board.presets());
        let new = seen(&mut board);
        assert_ne!(old, new);
        let (mut olds, mut news) = (0, 0);
        for n in 1.. {
            let mut board = Board::with_presets(contents);
            board.ok("set f_dynamic 1.25");
            board.machine.cut_power_at(n, n);
            if !goes_off_during(&mut board, command) {
                break;
            }
            if n % 3 == 0 {
                // and once more while it repairs, if there is something to be repaired
                board.machine.cut_power_at(1 + n / 3 % 2, n);
            }
            board.run(200.0);
            board.machine.cut_power_at(u64::MAX, 0);
            let found = seen(&mut board);
            assert!(found == old || found == new, "{what}, cut at {n}: {found:#?}");
            *(if found == new { &mut news } else { &mut olds }) += 1;
            assert_eq!(board.machine.violations().into_iter().collect::<String>(), "", "{what}, cut at {n}");
            if n % 4 == 0 {
                // it goes on from there
                board.ok("preset save third");
                assert!(board.ok("preset list").contains(" third"));
            }
        }
        println!("{what:46} {:10} {olds:5} {news:5}", olds + news);
        assert!(olds > 0 && olds + news >= 3);
    }
}

pub fn presets_survive_power_cuts_and_deletions_hold() {
    let mut board = Board::ready();
    for command in ["preset use rubber", "set f_dynamic 1.5", "preset save mine", "preset default mine"] {
        println!("{command:24} {}", board.ok(command));
    }
    assert_eq!(board.ok("preset save other"), "ok other saved in flash");
    board.ok("preset delete other");
    let mut board = Board::with_presets(&board.presets());
    let list = board.ok("preset list");
    println!("after power-on           {list}");
    assert_eq!(list, "ok brass teflon rubber viscous mine; active mine; default mine");
    assert_eq!(board.ok("get f_dynamic"), "ok f_dynamic 1.5 N", "it is what runs");
    board.ok("render on");
    board.machine.set_hand(|_: f64, _: f64, v: f64| 5.0 - 20.0 * v);
    board.run(60.0);
    assert!(board.machine.force() < -1.0, "and is felt: {} N", board.machine.force());
    assert_eq!(board.machine.violations().into_iter().collect::<String>(), "");
}

pub fn flash_writes_delay_no_step_and_lose_no_frame() {
    let mut contents = Shelf::before_a_page_is_collected();
    contents[BYTES - PAGE..].fill(0);
    let mut board = Board::with_presets(&contents);
    board.ok("render on");
    board.machine.set_hand(|t: f64, _: f64, v: f64| 6.0 * (6.0 * t).sin() - 5.0 * v);
    board.ok("stream on");
    board.run(20.0);
    board.machine.reset_statistics();
    board.frames.clear();
    let (begun, operations) = (board.machine.milliseconds(), board.machine.flash_operations());
    assert!(!goes_off_during(&mut board, "preset save third"));
    let took = board.machine.milliseconds() - begun;
    let operations = board.machine.flash_operations() - operations;
    board.run(20.0);
    let s = board.machine.statistics();
    println!(
        "a save that erases two pages: {operations} operations in {took:.1} ms; {} triggers, {} steps, {} missed, {} late; force out {:.2} us after the sample, spread {:.3} us; watchdog fed every {:.1} to {:.1} ms",
        s.triggers,
        s.steps,
        s.missed,
        s.stale_outputs,
        s.latency_us.mean(),
        s.latency_us.spread(),
        s.watchdog_gap_ms.min,
        s.watchdog_gap_ms.max,
    );
    assert!(took > 44.0, "two erasures of 22 ms and more");
    assert_eq!((s.triggers.abs_diff(s.steps) <= 1, s.missed, s.stale_outputs), (true, 0, 0));
    assert!(s.latency_us.spread() < 0.01 && s.watchdog_gap_ms.max < 12.0);
    let steps: Vec<u32> = board.samples().map(|(_, sample)| sample.step).collect();
    assert!(steps.len() > 60 && steps.windows(2).all(|w| w[1] == w[0].wrapping_add(1)), "a frame was lost");
    assert!(board.ok("stream off").contains(" 0 frames dropped"));
    assert!(board.ok("status").contains(" 0 late, 0 missed by the console"));
    assert_eq!(board.machine.violations().into_iter().collect::<String>(), "");
}

pub fn a_failed_flash_changes_nothing() {
    let mut board = Board::with_presets(&Shelf::usual().contents());
    let before = seen(&mut board);
    board.machine.poke(FLASH_KEYR, 0);
    for command in ["preset save third", "preset delete first", "preset default second"] {
        let answer = board.ask(command).swap_remove(0);
        println!("{command:24} {answer}");
        assert!(answer.starts_with("err FLASH: "), "{answer}");
    }
    assert_eq!(seen(&mut board), before);
}
