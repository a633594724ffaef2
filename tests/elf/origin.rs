//! The middle of the stroke on the running ELF: unknown after every start and reset, found by `home` from anywhere.

use crate::board::Board;
use emulator::ResetCause;

/// Largest force of a search, N: 70 % of the actuator's, and the resolution of the converter.
const SEARCH_N: f64 = 0.7 * 9.48 + 0.005;
/// Largest force of a contact while unreferenced, N.
const UNREFERENCED_N: f64 = 0.3 * 9.48 + 0.005;
/// Budget of a control step, cycles.
const BUDGET: f64 = 1_700.0;

/// Refuses what moves the handle, and says what to type.
fn is_unreferenced(board: &mut Board) {
    assert!(board.ok("status").contains(", unreferenced, "), "the status says so");
    for command in ["move sine 0.008 1", "identify", "selftest"] {
        let refused = board.ask(command).swap_remove(0);
        assert!(refused.starts_with("err UNREFERENCED: ") && refused.contains("`home`"), "{refused}");
        assert!(!board.machine.amplifier_on());
    }
}

pub fn home_finds_the_middle_from_anywhere_in_the_stroke() {
    for start in [0.0, 0.012, -0.012, 0.016, -0.016] {
        let mut board = Board::boot_at(start);
        is_unreferenced(&mut board);
        board.machine.reset_statistics();
        board.ok("home");
        let (mut force, mut speed) = (0.0_f64, 0.0_f64);
        let begun = board.machine.milliseconds();
        let told = loop {
            board.run(2.0);
            force = force.max(board.machine.force().abs());
            speed = speed.max(board.machine.truth().velocity.abs());
            let ends = |line: &&String| line.starts_with("! ");
            if let Some(line) = board.lines.iter().find(ends) {
                break line.clone();
            }
            assert!(board.machine.milliseconds() - begun < 9_700.0, "no end: {:?}", board.lines);
        };
        let took = board.machine.milliseconds() - begun;
        let s = board.machine.statistics();
        let off = 1e3 * board.machine.truth().position;
        println!(
            "from {:+.0} mm: {told}; {took:.0} ms, {force:.2} N, {:.0} mm/s, handle {off:+.2} mm, step {:.0} cycles",
            1e3 * start,
            1e3 * speed,
            s.step_cycles.max
        );
        assert!(told.starts_with("! home: stroke 32.0"), "{told}");
        assert!(force <= SEARCH_N && speed < 0.1 && off.abs() < 0.5);
        assert!(s.step_cycles.max < BUDGET, "{} cycles", s.step_cycles.max);
        assert_eq!((s.missed, s.stale_outputs), (0, 0));
        assert!(!board.machine.amplifier_on() && !board.ok("status").contains("unreferenced"));
        // an excitation of nearly the whole stroke ends nowhere near the stops
        board.ok("move sine 0.014 0.8 1");
        let mut reach = 0.0_f64;
        for _ in 0..300 {
            board.run(10.0);
            reach = reach.max(board.machine.truth().position.abs());
        }
        assert_eq!(board.ok("fault"), "ok no fault");
        assert!((0.012..0.0155).contains(&reach), "{reach}");
    }
}

pub fn a_start_at_a_stop_drives_nothing_into_it() {
    let mut board = Board::boot_at(0.016);
    is_unreferenced(&mut board);
    // rendering is allowed, with little force: a hand slides to the other stop and back
    let warned = board.ok("render on");
    assert!(warned.starts_with("ok warn: unreferenced: at most 2.84 N"), "{warned}");
    board.ok("preset use rubber");
    board.machine.set_hand(|t: f64, x: f64, v: f64| 4_000.0 * (0.017 * (3.0 * t).cos() - x) - 20.0 * v);
    let (mut force, mut lowest) = (0.0_f64, 0.0_f64);
    for _ in 0..1_200 {
        board.run(2.0);
        force = force.max(board.machine.force().abs());
        lowest = lowest.min(board.machine.truth().position);
    }
    println!("at a stop, unreferenced: rubber with at most {force:.2} N, handle to {:.1} mm", 1e3 * lowest);
    assert!(board.machine.amplifier_on() && board.ok("fault") == "ok no fault");
    assert!(force <= UNREFERENCED_N && force > 0.9 * UNREFERENCED_N && lowest < -0.0155);
}

pub fn a_reset_in_mid_stroke_leaves_the_device_unreferenced() {
    for cause in [ResetCause::Pin, ResetCause::Debugger, ResetCause::Watchdog] {
        let mut board = Board::boot_at(-0.005);
        assert!(board.home().starts_with("! home"));
        board.ok("move sine 0.012 0.5");
        board.run(1_600.0);
        let left_at = board.machine.truth().position;
        assert!(left_at.abs() > 0.005, "{left_at}");
        board.machine.reset_by(cause);
        for _ in 0..60 {
            board.run(1.0);
            assert!(!board.machine.amplifier_on(), "{cause:?}");
        }
        board.lines.clear();
        board.run(500.0);
        board.ask("clear");
        is_unreferenced(&mut board);
        let told = board.home();
        println!("{cause:?} at {:.1} mm: {told}", 1e3 * left_at);
        assert!(told.starts_with("! home: stroke 32.0") && board.machine.truth().position.abs() < 5e-4);
    }
}
