//! The firmware that reads the index pulse of the quadrature encoder, on channel 3 of TIM2.

use crate::board::{Board, image_with_index_pulse};
use emulator::{Machine, ResetCause};
use link::Frame;
use plant::RigConfig;

/// Travel in a count, m.
const COUNT: f64 = 2.57e-6;
/// Place of the index, m from the middle of the stroke.
const INDEX: f64 = 0.0043;
const KNOWN: &str = "! index: the middle of the stroke is known";

fn boot_at(start_position: f64) -> Board {
    let image = image_with_index_pulse();
    let config = RigConfig { start_position, ..RigConfig::free_handle() };
    let no_block = friction::Custom(|_: &friction::Motion<f64>| 0.0);
    let mut machine = Machine::boot(image, config, no_block, 1).expect("a place in the stroke");
    machine.set_index(INDEX);
    Board::with(image, machine)
}

fn homed() -> Board {
    let mut board = boot_at(-0.006);
    println!("{}", board.home());
    board.run(100.0);
    assert!(board.lines.iter().any(|l| l == "! middle of the stroke kept; in flash"), "{:?}", board.lines);
    board
}

/// Carries the handle by hand to a place of the stroke, m.
fn carry(board: &mut Board, to: f64) {
    board.machine.set_hand(move |_: f64, x: f64, v: f64| 800.0 * (to - x) - 30.0 * v);
    board.run(1_000.0);
    assert!((board.machine.truth().position - to).abs() < 2e-3);
}

/// Position that the device tells less the true one, m.
fn off(board: &mut Board) -> f64 {
    board.ok("stream on");
    board.run(30.0);
    let mut origins = board.frames.iter().filter_map(|(_, frame)| match frame {
        Frame::Header(header) => Some(header.origin_count),
        _ => None,
    });
    let origin = origins.next_back().expect("a header");
    let count = board.samples().last().expect("a frame").1.count;
    board.ok("stream off");
    board.frames.clear();
    f64::from(count - origin) * COUNT - board.machine.truth().position
}

fn is_unreferenced(board: &mut Board) -> bool {
    board.ok("status").contains("unreferenced")
}

pub fn a_start_knows_the_middle_once_the_index_has_passed() {
    let mut board = homed();
    let error = off(&mut board);
    assert!(error.abs() < 100e-6, "{error}");
    for (start, there, cause) in [
        (-0.009, 0.012, ResetCause::PowerOn),
        (0.013, -0.002, ResetCause::Pin),
        (0.001, 0.006, ResetCause::PowerOn),
    ] {
        carry(&mut board, start);
        board.machine.reset_by(cause);
        board.run(150.0);
        board.lines.clear();
        assert!(is_unreferenced(&mut board), "known before the index");
        let refused = board.ask("move sine 0.002 1");
        assert!(refused[0].contains("`home`"), "{refused:?}");
        carry(&mut board, there);
        assert_eq!(board.lines.iter().filter(|line| *line == KNOWN).count(), 1, "{:?}", board.lines);
        assert!(!is_unreferenced(&mut board));
        let again = off(&mut board);
        println!(
            "{cause:?} at {:.0} mm, moved to {:.0} mm: {:.1} um off",
            1e3 * start,
            1e3 * there,
            1e6 * again
        );
        assert!((again - error).abs() < 1.5 * COUNT, "{again} {error}");
        board.machine.set_hand(|_: f64, _: f64, v: f64| -20.0 * v);
        board.run(300.0);
        board.ok("move sine 0.002 1");
        board.run(50.0);
        board.ok("off");
        board.run(50.0);
    }
    // under a rendered contact the position does not jump: the middle is known once it has ended
    carry(&mut board, -0.003);
    board.machine.reset_by(ResetCause::PowerOn);
    board.run(150.0);
    board.lines.clear();
    board.ok("render on");
    board.machine.set_hand(|_: f64, x: f64, v: f64| 800.0 * (0.008 - x) - 30.0 * v);
    board.run(1_500.0);
    assert!(board.machine.truth().position > INDEX && !board.lines.iter().any(|line| line == KNOWN));
    board.ok("render off");
    board.run(30.0);
    assert!(board.lines.iter().any(|line| line == KNOWN), "{:?}", board.lines);
    assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
    let worst = board.machine.statistics().step_cycles.max;
    println!("control interrupt {worst:.0} cycles at most");
}

pub fn lost_counts_are_a_fault_at_the_next_pulse() {
    let mut board = homed();
    board.ok("preset use viscous");
    board.ok("render on");
    let swing = |t: f64, x: f64, v: f64| 6.0 * (6.0 * t).sin() - 100.0 * (x - INDEX) - 5.0 * v;
    board.machine.set_hand(swing);
    board.run(2_000.0);
    assert_eq!(board.ok("fault"), "ok no fault");
    // fewer than a check of every sample sees
    board.machine.slip_encoder(40);
    board.run(1_500.0);
    assert!(!board.machine.amplifier_on());
    let said = board.ok("fault");
    println!("40 counts lost: {said}");
    assert!(said.starts_with("ok encoder_jump"), "{said}");
    assert!(is_unreferenced(&mut board));
    board.machine.set_hand(|_: f64, _: f64, v: f64| -20.0 * v);
    board.run(300.0);
    board.ok("clear");
    board.lines.clear();
    carry(&mut board, -0.004);
    carry(&mut board, 0.009);
    assert!(board.lines.iter().any(|line| line == KNOWN), "{:?}", board.lines);
    let error = off(&mut board);
    println!("after the next pulse: {:.1} um off", 1e6 * error);
    assert!(error.abs() < 100e-6, "{error}");
    assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
}
