//! How fast the loop can go, and what that does to the coupling.

use crate::board::Board;
use haptics::RATES;

/// The largest stiffness that the device accepts at its present rate, N/m: it says so when more is asked for.
pub fn stiffest(board: &mut Board) -> f64 {
    let refused = board.ask("set k_vc 1e9").join(" ");
    let (_, most) = refused.rsplit_once(" to ").expect("a range");
    most.split([' ', ';', ',']).find_map(|word| word.parse().ok()).unwrap_or_else(|| panic!("{refused}"))
}

/// Root mean square of the handle's swing about its mean over 60 ms, µm.
fn swing(board: &mut Board) -> f64 {
    let positions: Vec<f64> = (0..240)
        .map(|_| {
            board.run(0.25);
            board.machine.truth().position * 1e6
        })
        .collect();
    let mean = positions.iter().sum::<f64>() / positions.len() as f64;
    (positions.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / positions.len() as f64).sqrt()
}

pub fn every_rate_misses_nothing_and_is_stable() {
    println!(
        "rate Hz  steps  missed  late  worst cycles  core awake  frames lost  largest k_vc N/m  swing after a knock, held"
    );
    for &hz in RATES {
        let mut board = Board::ready();
        board.ok(&format!("rate {hz}"));
        board.ok("preset use rubber");
        let most = stiffest(&mut board);
        board.ok("render on");
        board.ok(&format!("stream on {}", hz / 1_000));
        // slides, turns and sticks
        board.machine.set_hand(|t: f64, _: f64, v: f64| 6.0 * (6.0 * t).sin() - 5.0 * v);
        board.run(20.0);
        board.machine.reset_statistics();
        board.run(1_000.0);
        let s = board.machine.statistics();
        let off = board.ok("stream off");
        let lost: u64 =
            off.split(", ").nth(1).and_then(|w| w.split(' ').next()?.parse().ok()).expect("frames lost");
        // a block that sticks, on the stiffest coupling there is, knocked by 1 N for 2 ms
        board.ok("render off");
        board.ok("set f_static 9");
        // on a soft coupling first: without damping the stiff one is refused
        board.ok("set k_vc 100");
        board.ok("set b_vc 0");
        let bare = stiffest(&mut board);
        board.ok(&format!("set k_vc {bare}"));
        board.machine.set_hand(|_: f64, _: f64, v: f64| -20.0 * v);
        board.run(300.0);
        board.ok("render on");
        let knock = board.machine.milliseconds() * 1e-3;
        board.machine.set_hand(move |t: f64, _: f64, v: f64| if t < knock + 2e-3 { 1.0 } else { -2.0 * v });
        board.run(4.0);
        let (first, later) = (swing(&mut board), {
            board.run(200.0);
            swing(&mut board)
        });
        println!(
            "{hz:7}  {:5}  {:6}  {:4}  {:12.0}  {:8.1} %  {lost:11}  {most:8.0} ({bare:.0} with B = 0)  {first:.2} then {later:.2} um",
            s.steps,
            s.missed,
            s.stale_outputs,
            s.step_cycles.max,
            100.0 * s.load(),
        );
        assert_eq!(
            (s.triggers, s.steps, s.missed, s.stale_outputs, lost),
            (u64::from(hz), u64::from(hz), 0, 0, 0)
        );
        assert!(later < first, "at {hz} Hz the coupling the device accepted rings on");
        assert!(board.machine.violations().is_empty(), "{:?}", board.machine.violations());
    }
}

pub fn unstable_rates_and_running_modes_refuse_rate() {
    let mut board = Board::ready();
    board.ok("rate 10000");
    board.ok("set k_vc 100000");
    let refused = board.ask("rate 1000").join(" ");
    println!("{refused}");
    assert!(refused.starts_with("err REFUSED: k_vc = 100000"), "{refused}");
    assert_eq!(board.ok("rate"), "ok rate 10000 Hz");
    board.ok("render on");
    let busy = board.ask("rate 20000").join(" ");
    println!("{busy}");
    assert!(busy.starts_with("err BUSY"), "{busy}");
    let bad = board.ask("rate 3000").join(" ");
    assert!(bad.contains("expected 1000, 2000, 5000, 10000 or 20000"), "{bad}");
}
