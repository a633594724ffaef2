//! The self-test and the calibration of the flashed ELF.

use crate::board::{Board, image};
use emulator::{Machine, ResetCause};
use plant::{Bench, RigConfig, Wire, Wiring};

/// Names of the checks that failed.
fn failed(lines: &[String]) -> Vec<&str> {
    let fails = lines.iter().filter_map(|line| line.trim().strip_prefix("FAIL  "));
    fails.map(|rest| rest.split(':').next().unwrap_or(rest)).collect()
}

pub fn selftest_names_each_wiring_error() {
    let right = Wiring::default();
    let (swapped, dead) = (Wire::Swapped, Wire::Dead);
    let mut board = Board::with_block(&plant::materials::RUBBER).expect("a compiler: the suite asks for one");
    for (name, wiring, expected) in [
        ("right", right, vec![]),
        ("encoder swapped", Wiring { encoder: swapped, ..right }, vec!["encoder"]),
        ("load cell swapped", Wiring { load: swapped, ..right }, vec!["load cell"]),
        ("load cell dead", Wiring { load: dead, ..right }, vec!["load cell"]),
        ("accelerometer swapped", Wiring { accel: swapped, ..right }, vec!["accelerometer"]),
        ("accelerometer dead", Wiring { accel: dead, ..right }, vec!["accelerometer"]),
        ("amplifier dead", Wiring { amplifier: dead, ..right }, vec!["amplifier"]),
        ("amplifier swapped", Wiring { amplifier: swapped, ..right }, vec!["amplifier"]),
        ("encoder dead", Wiring { encoder: dead, ..right }, vec!["encoder"]),
    ] {
        board.machine.rewire(wiring);
        board.run(50.0);
        // an exchanged encoder has jumped: the origin is lost
        board.ok("zero");
        let lines = board.ask("selftest");
        println!("{name:<22} {}", lines[0]);
        for line in lines.iter().filter(|line| line.contains("FAIL")) {
            println!("                       {}", line.trim());
        }
        assert_eq!(failed(&lines), expected, "{name}: {lines:#?}");
        assert!(!board.machine.amplifier_on());
    }
}

pub fn two_weights_calibrate_the_load_cell() {
    let mut board = Board::ready();
    for weight in [0.0, 9.81] {
        board.machine.put_on_bench(Bench { weight, gravity: 0.0 }).expect("in range");
        board.run(20.0);
        println!("{}", board.ok(&format!("calibrate load {weight}")));
    }
    let saved = board.ok("calibrate save");
    println!("{saved}");
    let unit: f64 = saved
        .split("load: ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next())
        .and_then(|text| text.parse().ok())
        .unwrap_or(f64::NAN);
    assert!((unit / (88.96 / 65_536.0) - 1.0).abs() < 0.005, "{unit}");
    board.run(20.0);
    let status = board.ok("status");
    assert!(status.contains(", load 9."), "{status}");
    assert!(saved.ends_with("; in flash"), "{saved}");
    // it once lasted until the device restarted
    let kept = board.ok("calibrate status");
    assert!(kept.contains(&format!("load: {unit:.7} N per code")), "{kept}");
    for cause in [ResetCause::Pin, ResetCause::PowerOn] {
        board.machine.reset_by(cause);
        board.run(60.0);
        assert_eq!(board.ok("calibrate status"), kept, "{cause:?}");
    }
}

pub fn without_its_flash_a_calibration_warns() {
    let mut machine = Machine::free_handle(image(), 1);
    machine.set_dual_bank(false);
    let mut board = Board::of(machine);
    for weight in [0.0, 9.81] {
        board.machine.put_on_bench(Bench { weight, gravity: 0.0 }).expect("in range");
        board.run(20.0);
        board.ok(&format!("calibrate load {weight}"));
    }
    let saved = board.ok("calibrate save");
    println!("{saved}");
    assert!(
        saved.starts_with("ok warn: calibrate") && saved.contains("until the device restarts: "),
        "{saved}"
    );
}

/// What a calibration of the force says at its end.
fn calibrate_force(board: &mut Board) -> String {
    println!("{}", board.ok("calibrate force"));
    board.lines.clear();
    for _ in 0..280 {
        board.run(50.0);
        if let Some(line) = board.lines.iter().find(|line| line.starts_with("! ")) {
            return line.clone();
        }
    }
    panic!("no result within 14 s: {:?}", board.lines);
}

/// A handle that somebody holds in the middle, with this friction of its guide, N.
fn held(friction: f64, gain: f64, at_zero: f64) -> Board {
    let free = RigConfig::free_handle();
    let config = RigConfig { device_friction_p: friction, device_friction_n: friction, ..free };
    let no_block = friction::Custom(|_: &friction::Motion<f64>| 0.0);
    let mut board = Board::of(Machine::boot(image(), config, no_block, 1).expect("a rig"));
    board.machine.set_amplifier(gain, at_zero);
    board.ok("zero");
    board.machine.set_hand(|_: f64, x: f64, v: f64| -2_000.0 * x - 60.0 * v);
    board
}

pub fn the_load_cell_calibrates_the_force() {
    for (friction, gain, at_zero) in [(0.0, 1.0, 0.0), (0.0, 1.06, 0.15), (0.9, 1.06, -0.15)] {
        let mut board = held(friction, gain, at_zero);
        let said = calibrate_force(&mut board);
        println!("friction {friction} N, gain {gain}, {at_zero} N at zero: {said}");
        assert!(said.starts_with("! calibrate; ") && said.ends_with("; in flash"), "{said}");
        assert!(!board.machine.amplifier_on());
        // what the amplifier gives is what is asked for, after a reset, too
        board.machine.reset_by(ResetCause::Pin);
        board.run(60.0);
        board.ok("zero");
        assert!(board.ok("calibrate status").contains("; force: "), "the channel is listed");
        board.ok("preset use rubber");
        board.ok("set f_static 9");
        board.ok("render on");
        let mut worst = 0.0_f64;
        for hand in [1.0, 4.0, 8.0, -1.0, -4.0, -8.0] {
            board.machine.set_hand(move |_: f64, _: f64, v: f64| hand - 20.0 * v);
            board.run(300.0);
            let status = board.ok("status");
            let told: f64 = status
                .split(", force ")
                .nth(1)
                .and_then(|rest| rest.split(' ').next()?.parse().ok())
                .unwrap_or(f64::NAN);
            worst = worst.max((board.machine.force() - told).abs());
        }
        println!("    the force is off by {worst:.4} N at most");
        assert!(worst < 0.03, "{worst} N");
    }
}

pub fn what_is_not_the_force_is_not_calibrated() {
    for (what, hand, gain, says) in [
        ("released", 0.0, 1.0, "the handle moved: "),
        ("an amplifier of half the gain", 2_000.0, 0.5, "the load cell shows 0.5"),
        ("too little for force_max", 2_000.0, 0.9, "the output gives 8."),
    ] {
        let mut board = held(0.0, gain, 0.0);
        let before = board.ok("calibrate status");
        board
            .machine
            .set_hand(move |_: f64, x: f64, v: f64| if hand > 0.0 { -hand * x - 60.0 * v } else { 0.0 });
        let said = calibrate_force(&mut board);
        println!("{what}: {said}");
        assert!(said.starts_with("! no calibration of the force: ") && said.contains(says), "{said}");
        assert_eq!(board.ok("calibrate status"), before);
        assert!(!board.machine.amplifier_on());
    }
    let mut board = held(0.0, 1.0, 0.0);
    board.ok("calibrate force");
    board.run(3_000.0);
    assert!(board.machine.force() > 1.0);
    assert!(board.ask("calibrate force")[0].starts_with("err BUSY: "));
    board.ok("off");
    assert!(!board.machine.amplifier_on());
    board.run(20.0);
    assert!(board.lines.iter().any(|line| line.ends_with("of the force: interrupted")), "{:?}", board.lines);
    // unreferenced
    let mut board = Board::boot();
    let refused = board.ask("calibrate force").swap_remove(0);
    assert!(refused.starts_with("err UNREFERENCED: "), "{refused}");
}
