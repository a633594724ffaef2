//! The start of the ELF: every cause of a reset, the option bytes, and the first power-up as the README tells it.

use crate::board::{Board, image};
use emulator::{Machine, ResetCause};
use plant::Bench;

pub fn every_reset_cause_boots_and_unexpected_ones_are_faults() {
    for (cause, fault) in [
        (ResetCause::PowerOn, "no fault"),
        (ResetCause::Pin, "no fault"),
        (ResetCause::Debugger, "no fault"),
        (ResetCause::DebuggerAfterWatchdog, "no fault"),
        (ResetCause::OptionBytes, "no fault"),
        (ResetCause::Watchdog, "watchdog"),
        (ResetCause::WindowWatchdog, "watchdog"),
        (ResetCause::LowPower, "hardware"),
    ] {
        let mut board = Board::boot();
        board.ok("render on");
        board.run(50.0);
        assert!(board.machine.amplifier_on());
        board.machine.reset_by(cause);
        for _ in 0..60 {
            assert!(!board.machine.amplifier_on(), "{cause:?}");
            board.run(1.0);
        }
        let told = board.ok("fault");
        println!("{cause:?}: {told}");
        assert!(told.starts_with(&format!("ok {fault}")), "{cause:?}: {told}");
        assert!(board.machine.violations().is_empty(), "{cause:?}: {:?}", board.machine.violations());
        board.ok("clear");
        assert!(board.ok("status").contains("unreferenced"), "{cause:?}");
        assert!(board.ask("move sine 0.008 1")[0].starts_with("err UNREFERENCED"), "{cause:?}");
        board.ok("render on");
        board.run(5.0);
        assert!(board.machine.amplifier_on(), "{cause:?}: no way on");
    }
}

/// The number after a word of the status.
fn number(status: &str, word: &str) -> f64 {
    let (_, rest) = status.split_once(word).expect(word);
    rest.split_whitespace().next().and_then(|text| text.parse().ok()).expect("a number")
}

pub fn the_first_power_up_of_the_readme_works() {
    let mut machine = Machine::free_handle(image(), 1);
    // as `cargo run` leaves it: flashed by a debugger, which then resets the chip
    machine.run_for(3.0);
    machine.reset_by(ResetCause::DebuggerAfterWatchdog);
    let mut board = Board::of(machine);
    // 1
    assert!(board.ok("version").contains("NUCLEO-G474RE"));
    assert_eq!(board.ok("fault"), "ok no fault");
    // 2: moved by hand, by the distance moved
    let (before, from) = (number(&board.ok("status"), "handle "), board.machine.truth().position);
    board.machine.set_hand(|_: f64, x: f64, v: f64| 300.0 * (0.005 - x) - 20.0 * v);
    board.run(1_500.0);
    let moved = board.machine.truth().position - from;
    assert!((number(&board.ok("status"), "handle ") - before - moved).abs() < 1e-5 && moved > 0.004);
    // 3: pulled at the load cell
    board.machine.put_on_bench(Bench { weight: 5.0, gravity: 0.0 }).expect("in range");
    board.run(20.0);
    assert!((number(&board.ok("status"), "load ").abs() - 5.0).abs() < 0.5);
    board.machine.put_on_bench(Bench::default()).expect("in range");
    // 4: no force, and the enable line low, also in reset
    assert!(!board.machine.amplifier_on() && board.machine.force() == 0.0);
    board.machine.reset_by(ResetCause::Pin);
    for _ in 0..600 {
        board.run(0.1);
        assert!(!board.machine.amplifier_on());
    }
    // 5: nothing moves by itself before the middle of the stroke is known
    assert!(board.ask("selftest")[0].starts_with("err UNREFERENCED"));
    board.machine.set_hand(|_: f64, x: f64, v: f64| -300.0 * x - 20.0 * v);
    board.run(1_500.0);
    board.machine.set_hand(|_: f64, _: f64, _: f64| 0.0);
    board.run(300.0);
    board.ok("zero");
    assert!(board.ok("selftest").starts_with("ok selftest passed"));
    // 6: once the handle rests
    board.run(500.0);
    assert!(board.home().starts_with("! home: stroke 32.0"));
    // 7
    board.ok("preset use viscous");
    assert_eq!(board.ok("render on"), "ok render on");
    board.run(100.0);
    assert!(board.machine.amplifier_on() && board.machine.force().abs() < 0.1, "silent at rest");
    board.machine.set_hand(|_: f64, _: f64, v: f64| 3.0 - 1.0 * v);
    board.run(100.0);
    assert!(board.machine.force() < -0.3, "resists motion: {}", board.machine.force());
    assert_eq!(board.ok("render off"), "ok render off");
    assert!(!board.machine.amplifier_on());
    assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
}

pub fn a_single_bank_of_flash_keeps_no_presets() {
    let mut machine = Machine::free_handle(image(), 1);
    machine.set_dual_bank(false);
    let mut board = Board::of(machine);
    let list = board.ok("preset list");
    println!("{list}");
    assert!(list.contains("option byte DBANK = 0: accepted 1"), "{list}");
    board.ok("preset use rubber");
    board.ok("set f_dynamic 1.5");
    let before = board.machine.flash_operations();
    let refused = board.ask("preset save mine").swap_remove(0);
    assert!(refused.starts_with("err FLASH: option byte DBANK = 0"), "{refused}");
    assert_eq!(board.machine.flash_operations(), before, "nothing is erased or programmed");
    board.ok("render on");
}

pub fn a_low_brown_out_level_is_said() {
    for (level, warned, resets) in [(0, true, false), (2, true, false), (4, false, true)] {
        let mut machine = Machine::free_handle(image(), 1);
        machine.set_brown_out_level(level);
        let mut board = Board::of(machine);
        let (version, status) = (board.ok("version"), board.ok("status"));
        println!("{version}\n{status}");
        assert_eq!(version.contains(&format!("BOR_LEV is {level}")), warned, "{version}");
        assert_eq!(status.contains(&format!(", BOR_LEV {level} of 4")), warned, "{status}");
        board.machine.set_supply(2_750);
        assert_eq!(!board.machine.resets().is_empty(), resets, "level {level}");
    }
}
