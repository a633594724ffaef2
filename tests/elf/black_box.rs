//! The first fault, kept over the reset that followed.

use crate::board::Board;

/// CR1 of TIM6, which paces the loop.
const TIM6_CR1: u32 = 0x4000_1000;

fn rendering() -> Board {
    let mut board = Board::ready();
    board.ok("preset use rubber");
    board.ok("render on");
    board.machine.set_hand(|_: f64, _: f64, v: f64| 2.0 - 20.0 * v);
    board.run(300.0);
    board
}

fn number_after(text: &str, name: &str) -> f64 {
    let word = text.split(name).nth(1).and_then(|rest| rest.split_whitespace().next());
    word.and_then(|word| word.trim_end_matches(',').parse().ok()).unwrap_or(f64::NAN)
}

/// After the reset: what `fault` says of before; `clear` forgets it.
fn told(board: &mut Board, what: &str) -> String {
    board.machine.set_hand(|_: f64, x: f64, v: f64| -200.0 * x - 20.0 * v);
    board.run(400.0);
    board.machine.set_hand(|_: f64, _: f64, _: f64| 0.0);
    board.run(200.0);
    assert_eq!(board.machine.resets().len(), 1, "{what}: {:?}", board.machine.resets());
    let fault = board.ok("fault");
    println!("{what:20} {fault}");
    board.ok("clear");
    board.run(5.0);
    assert_eq!(board.ok("fault"), "ok no fault", "{what}");
    let (_, first) = fault.split_once("; first, before the restart: ").expect("something was kept");
    first.to_owned()
}

pub fn a_reset_reports_its_reason_and_motion() {
    type Inject = fn(&mut Board);
    let injections: [(&str, Inject); 4] = [
        ("panic", |board| assert!(board.machine.run_into_task() && board.machine.panic_here())),
        ("panic", |board| assert!(board.machine.run_into_control() && board.machine.panic_here())),
        ("crash", |board| board.machine.derail(0x6000_0000)),
        ("missed_deadline", |board| board.machine.poke(TIM6_CR1, 0)),
    ];
    for (kind, inject) in injections {
        let mut board = rendering();
        let (steps, position) =
            (number_after(&board.ok("status"), "step ").trunc(), board.machine.truth().position);
        inject(&mut board);
        board.run(60.0);
        let first = told(&mut board, kind);
        assert!(
            first.starts_with(&format!("{kind} at step ")) && first.contains(" while rendering: "),
            "{first}"
        );
        assert!((0.0..40.0).contains(&(number_after(&first, "step ") - steps)), "{first}, {steps}");
        assert!((number_after(&first, "handle ") - position).abs() < 1e-4, "{first}, {position}");
        assert!((number_after(&first, "force ") + 2.0).abs() < 0.3, "{first}");
        // the line that the emulated panic names
        assert_eq!(first.ends_with(":7"), kind == "panic", "{first}");
        // where the processor was sent
        assert_eq!(first.contains(", crashed at pc 0x60000000, lr 0x"), kind == "crash", "{first}");
    }
}

pub fn a_crash_keeps_the_first_fault() {
    let mut board = rendering();
    board.machine.press_stop(true);
    board.run(20.0);
    board.machine.press_stop(false);
    board.machine.derail(0x6000_0000);
    board.run(60.0);
    let first = told(&mut board, "stop, then crash");
    assert!(first.starts_with("emergency_stop at step ") && first.contains(" while rendering: "), "{first}");
}
