//! What a control step costs on the target under every law and every renderer.

use crate::board::Board;
use haptics::{LawKind, RendererKind};

/// Budget of a control step, cycles: a tenth of the period at 10 kHz.
const BUDGET: f64 = 1_700.0;
/// LuGre takes two exponentials and does not meet it: what it may take until it does.
const LUGRE: f64 = 1_950.0;

#[test]
fn every_law_under_every_renderer_stays_within_the_cycles_of_a_step() {
    let Some(mut board) = Board::boot() else { return };
    board.ok("preset use rubber");
    for (name, value) in
        [("f_static", "3.5"), ("f_dynamic", "3"), ("damping", "4"), ("sigma", "8000"), ("dv", "0.01")]
    {
        board.ok(&format!("set {name} {value}"));
    }
    // slides, turns and sticks
    board.machine.set_hand(|t: f64, _: f64, v: f64| 6.0 * (12.0 * t).sin() - 5.0 * v);
    board.ok("stream on");
    let renderers: String = RendererKind::ALL.iter().map(|r| format!("{:>18}", r.id())).collect();
    println!("{:40}{renderers}", "control interrupt, cycles: mean (worst)");
    for law in LawKind::ALL {
        board.ok(&format!("set law {}", law.id()));
        let mut row = format!("{:40}", law.id());
        for renderer in RendererKind::ALL {
            board.ok(&format!("set renderer {}", renderer.id()));
            board.ok("render on");
            board.run(20.0);
            board.machine.reset_statistics();
            board.run(600.0);
            let cycles = board.machine.statistics().step_cycles;
            row += &format!("{:>10.0} ({:5.0})", cycles.mean(), cycles.max);
            let most = if *law == LawKind::LuGre { LUGRE } else { BUDGET };
            assert!(cycles.max < most, "{} with {}: {} cycles", law.id(), renderer.id(), cycles.max);
            board.ok("render off");
        }
        println!("{row}");
    }
}
