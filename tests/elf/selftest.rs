//! The self-test and the calibration of the flashed ELF.

use crate::board::{Board, image};
use emulator::{Machine, ResetCause};
use plant::{Bench, Wire, Wiring};

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
