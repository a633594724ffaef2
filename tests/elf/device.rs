//! The ELF on a device that is not the one it expects: other resolution and stroke, encoder, amplifier and load cell reversed.

use crate::board::{Board, image};
use emulator::{Machine, ResetCause};
use plant::materials::BRASS;
use plant::{RigConfig, Sensor, Wire, Wiring};

/// The settings of that device.
const SET: &str = "device set stroke 0.05 resolution -5e-6 force_gain -6.6666665 load_gain -26.957575";

/// That device, with brass under its handle.
fn other() -> Machine {
    let normal = RigConfig { block_mass: BRASS.mass, ..RigConfig::default() };
    let mut config = RigConfig {
        stroke: Some(0.05),
        start_position: 0.018,
        load: Sensor { gain: -1.0, ..normal.load },
        wiring: Wiring { encoder: Wire::Swapped, amplifier: Wire::Swapped, ..Wiring::default() },
        ..normal
    };
    config.calibration.metre_per_count = 5e-6;
    Machine::boot(image(), config, BRASS.law, 1).expect("a rig")
}

pub fn another_device_homes_and_identifies_after_a_reset() {
    let mut board = Board::of(other());
    println!("{}", board.home());
    board.ok("off");
    let said = board.ok(SET);
    println!("{said}");
    assert!(said.ends_with("; in flash"), "{said}");
    board.machine.reset_by(ResetCause::Pin);
    board.run(60.0);
    let listed = board.ask("device");
    assert!(listed[2].contains("0.05 m;") && listed[3].contains("-0.000005 m;"), "{listed:?}");
    let told = board.home();
    println!("{told}; handle {:+.2} mm", 1e3 * board.machine.truth().position);
    assert!(told.starts_with("! home: stroke 50.0"), "{told}");
    assert!(board.machine.truth().position.abs() < 0.7e-3);
    // the position grows in the positive direction of the rig
    board.ok("move dwell 0.01 0.5 2");
    board.machine.reset_statistics();
    for _ in 0..30 {
        board.run(100.0);
        let words = board.ok("status");
        let at: f64 = words
            .split("handle ")
            .nth(1)
            .and_then(|rest| rest.split(' ').next()?.parse().ok())
            .unwrap_or_else(|| panic!("{words}"));
        let truth = board.machine.truth().position;
        assert!((at - truth).abs() < 1.5e-3, "{at} m, truth {truth} m");
    }
    board.run(1_000.0);
    println!("{}", board.ok("fault"));
    board.lines.clear();
    board.ok("identify");
    let found = loop {
        board.run(500.0);
        if let Some(line) = board.lines.iter().find(|line| line.starts_with("! ")) {
            break line.clone();
        }
    };
    println!("{found}");
    for (name, truth) in [("mass", BRASS.mass), ("C_p", BRASS.law.c_p), ("C_n", BRASS.law.c_n)] {
        let mut words = found.split(&format!(" {name} ")).nth(1).expect("in the line").split(' ');
        let value: f64 = words.next().and_then(|word| word.parse().ok()).expect("a number");
        println!("{name} {value}, true {truth}");
        assert!((value / truth - 1.0).abs() < 0.05, "{name}");
    }
    println!("step {:.0} cycles at most", board.machine.statistics().step_cycles.max);
}

pub fn a_power_cut_leaves_the_old_or_the_new_device() {
    let (mut olds, mut news) = (0, 0);
    for n in 1.. {
        let mut board = Board::boot();
        let old = board.ask("device");
        board.machine.cut_power_at(n, n);
        board.lines.clear();
        board.machine.serial_write(format!("{SET}\n").as_bytes());
        board.run(300.0);
        let cut = !board.machine.resets().is_empty();
        board.machine.cut_power_at(u64::MAX, 0);
        let found = board.ask("device");
        if found == old {
            olds += 1;
        } else {
            news += 1;
            assert!(found[2].contains("0.05 m;") && found[3].contains("-0.000005 m;"), "{found:?}");
            assert!(found[8].contains("-6.66") && found[9].contains("-26.9"), "{found:?}");
        }
        if !cut {
            break;
        }
    }
    println!("{olds} cuts left the old device, {news} the new one");
    assert!(olds > 0 && news > 0);
}
