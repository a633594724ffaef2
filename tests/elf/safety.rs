//! What takes the force off.

use crate::board::Board;
use emulator::ResetCause;

/// CR1 of TIM6, which paces the loop.
const TIM6_CR1: u32 = 0x4000_1000;
/// The control loop has stopped: the watchdog resets the chip within this, ms (the firmware asks for 50).
const WATCHDOG_MS: f64 = 65.0;

fn rendering() -> Option<Board> {
    let mut board = Board::boot()?;
    board.ok("preset use rubber");
    board.ok("render on");
    board.machine.set_hand(|_: f64, _: f64, v: f64| 2.0 - 20.0 * v);
    board.run(300.0);
    assert!(board.machine.amplifier_on() && board.machine.force() < -1.5, "{}", board.machine.force());
    Some(board)
}

#[test]
fn a_loop_that_stops_is_reset_by_the_watchdog_and_waits_for_a_person() {
    let Some(mut board) = rendering() else { return };
    let stopped = board.machine.milliseconds();
    board.machine.poke(TIM6_CR1, 0);
    board.run(WATCHDOG_MS);
    let [(at, ResetCause::Watchdog)] = board.machine.resets() else { panic!("{:?}", board.machine.resets()) };
    println!("pace stopped; reset by the watchdog after {:.1} ms", at - stopped);
    assert!(!board.machine.amplifier_on());
    board.run(50.0);
    assert!(!board.machine.amplifier_on(), "off after the reset too");
    board.machine.set_hand(|_: f64, _: f64, _: f64| 0.0);
    let fault = board.ok("fault");
    println!("{fault}");
    assert!(fault.starts_with("ok hardware"), "{fault}");
    assert!(board.ask("render on")[0].starts_with("err"));
    assert!(!board.machine.amplifier_on());
}

#[test]
fn the_emergency_stop_takes_the_force_off_and_cannot_be_cleared_while_it_is_pressed() {
    let Some(mut board) = rendering() else { return };
    board.machine.press_stop(true);
    let pressed = board.machine.milliseconds();
    while board.machine.amplifier_on() && board.machine.milliseconds() - pressed < 20.0 {
        board.machine.run_for(0.1);
    }
    let after = board.machine.milliseconds() - pressed;
    println!("amplifier off {after:.1} ms after the stop was pressed");
    assert!(after < 3.2, "{after} ms");
    board.machine.set_hand(|_: f64, x: f64, v: f64| -200.0 * x - 20.0 * v);
    board.run(1_000.0);
    board.machine.set_hand(|_: f64, _: f64, _: f64| 0.0);
    board.run(200.0);
    assert!(board.ok("fault").starts_with("ok emergency_stop"));
    board.ask("clear");
    board.run(10.0);
    assert!(board.ask("render on")[0].starts_with("err"), "cleared, but still pressed");
    for _ in 0..50 {
        board.run(1.0);
        assert!(!board.machine.amplifier_on());
    }
    board.machine.press_stop(false);
    board.run(10.0);
    board.ok("clear");
    board.ok("render on");
    assert!(board.machine.amplifier_on());
}

#[test]
fn a_spark_on_the_stop_line_stops_nothing() {
    let Some(mut board) = rendering() else { return };
    board.machine.press_stop(true);
    board.run(1.5);
    board.machine.press_stop(false);
    board.run(20.0);
    assert!(board.machine.amplifier_on());
    assert_eq!(board.ok("fault"), "ok no fault");
}

#[test]
fn a_processor_that_runs_astray_takes_the_force_off_at_once() {
    let Some(mut board) = rendering() else { return };
    // nothing is mapped there
    board.machine.derail(0x6000_0000);
    // it may be asleep: the next interrupt wakes it
    let astray = board.machine.milliseconds();
    board.machine.run_for(1.5);
    let [(at, ResetCause::Software)] = board.machine.resets() else { panic!("{:?}", board.machine.resets()) };
    let after = at - astray;
    assert!(!board.machine.amplifier_on() && !board.machine.locked_up());
    board.machine.set_hand(|_: f64, _: f64, _: f64| 0.0);
    board.run(50.0);
    assert!(board.ok("fault").starts_with("ok hardware"));
    println!("reset by the fault handler after {after:.3} ms, amplifier off, fault latched");
    // a person has looked
    board.run(100.0);
    board.ok("clear");
    board.ok("render on");
    assert!(board.machine.amplifier_on());
}
