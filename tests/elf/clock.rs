//! The clock of the board: its crystal, and the internal oscillator without it.

use crate::board::{Board, image};
use emulator::{Machine, ResetCause};

pub fn a_board_without_its_crystal_runs_and_says_so() {
    let mut board = Board::ready();
    assert!(board.ok("version").contains(", crystal"), "{}", board.ok("version"));
    assert!(!board.ok("status").contains("internal clock"));
    let mut machine = Machine::free_handle(image(), 1);
    machine.set_crystal(false);
    let mut board = Board::of(machine);
    board.run(50.0);
    println!(
        "{}, first step after {:.1} ms",
        board.ok("version"),
        board.machine.first_step_ms().expect("it runs")
    );
    assert!(board.ok("version").contains("internal clock, off by up to 1 %: the crystal does not start"));
    assert!(board.ok("status").contains(", internal clock"), "{}", board.ok("status"));
    assert_eq!(board.ok("fault"), "ok no fault");
    board.ok("zero");
    board.ok("render on");
    assert!(board.machine.amplifier_on());
    assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
}

pub fn a_crystal_that_stops_takes_the_force_and_the_device_goes_on_without_it() {
    let mut board = Board::ready();
    board.ok("render on");
    board.machine.set_crystal(false);
    board.run(0.1);
    assert!(!board.machine.amplifier_on());
    board.run(150.0);
    assert!(matches!(board.machine.resets(), [(_, ResetCause::Software)]), "{:?}", board.machine.resets());
    assert!(board.ok("fault").starts_with("ok clock "), "{}", board.ok("fault"));
    assert!(board.ok("version").contains("internal clock"));
    board.ok("clear");
    board.ok("render on");
    board.run(5.0);
    assert!(board.machine.amplifier_on());
    // and with the crystal again after the next reset
    board.machine.set_crystal(true);
    board.machine.reset_by(ResetCause::Pin);
    board.run(60.0);
    assert!(board.ok("version").contains(", crystal"));
}

pub fn an_internal_clock_off_by_one_percent_loses_no_step_and_no_byte() {
    for parts in [-100, 100] {
        let mut machine = Machine::free_handle(image(), 1);
        machine.set_crystal(false);
        machine.set_internal_clock_error(parts);
        let mut board = Board::of(machine);
        board.run(50.0);
        board.ok("zero");
        board.ok("render on");
        board.machine.reset_statistics();
        board.run(1_000.0);
        let s = board.machine.statistics();
        let expected = 1_000.0 * (1.0 + parts as f64 / 10_000.0);
        println!(
            "internal clock {:+} %: {} steps in 1 s, {} missed",
            parts as f64 / 100.0,
            s.steps,
            s.missed
        );
        assert!((s.steps as f64 - expected).abs() <= 1.0 && s.missed + s.stale_outputs == 0);
        assert_eq!(board.corrupt, 0);
        assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
    }
}
