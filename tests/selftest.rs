//! `selftest` finds what is wrong and nothing else; `calibrate` finds gain and zero, or says why not.
#![cfg(not(target_os = "none"))]

mod common;

use common::Bench;
use plant::{RigConfig, Sensor, materials};
use tribos_firmware::board::simulated::Holder;

/// The checks that failed, by their names.
fn failed(lines: &[String]) -> Vec<&str> {
    let fails = lines.iter().filter_map(|line| line.trim().strip_prefix("FAIL  "));
    fails.map(|rest| rest.split(':').next().unwrap_or(rest)).collect()
}

#[test]
fn each_wiring_error_fails_only_its_check() {
    for block in ["none", "brass", "teflon", "rubber"] {
        for (wire, expected, advice) in [
            ("amplifier right", vec![], ""),
            ("encoder swapped", vec!["encoder"], "exchange its channels A and B"),
            ("load swapped", vec!["load cell"], "exchange its two signal wires"),
            ("load dead", vec!["load cell"], "check the connection"),
            ("accel swapped", vec!["accelerometer"], "reverse its orientation"),
            ("accel dead", vec!["accelerometer"], "check the connection"),
            ("amplifier dead", vec!["amplifier"], "check enable, supply and motor wires"),
            ("amplifier swapped", vec!["amplifier"], "exchange the motor wires"),
        ] {
            let rig =
                RigConfig { device_friction_p: 1.04, device_friction_n: 0.69, ..RigConfig::free_handle() };
            let mut bench = Bench::new(rig, 7);
            bench.say("zero");
            bench.say(&format!("sim block {block}"));
            bench.say(&format!("sim wire {wire}"));
            bench.run(100);
            let lines = bench.ask("selftest");
            if block == "rubber" {
                println!("sim wire {wire}\n  {}", lines.join("\n  "));
            }
            assert_eq!(failed(&lines), expected, "{wire}, block {block}: {lines:#?}");
            assert!(lines.iter().any(|line| line.contains(advice)), "{lines:?}");
            let moved = bench.device.truth().position;
            assert!(!bench.device.outputs().amplifier && moved.abs() < 4e-3, "{moved}");
        }
    }
}

#[test]
fn a_dead_encoder_ends_the_push_by_its_fault() {
    let mut bench = Bench::new(RigConfig::free_handle(), 3);
    bench.say("zero");
    bench.say("sim wire encoder dead");
    let lines = bench.ask("selftest");
    println!("{}", lines.join("\n"));
    assert_eq!(failed(&lines), ["encoder"]);
    assert!(lines[2].ends_with("counts no push; check its cable and supply"), "{lines:?}");
    assert!(bench.say("fault").starts_with("ok encoder_silent"));
    assert!(!bench.device.outputs().amplifier);
}

#[test]
fn a_held_handle_is_not_pushed() {
    let mut bench = Bench::new(RigConfig::free_handle(), 3);
    bench.say("zero");
    bench.device.hold(Holder::Hand(plant::HandImpedance {
        mass: 0.5,
        stiffness: 5e5,
        damping: 500.0,
        target: plant::Target::Hold { position: 0.0 },
    }));
    let lines = bench.ask("selftest");
    println!("{}", lines.join("\n"));
    assert_eq!(failed(&lines), ["amplifier"]);
    assert!(lines[5].contains("handle held or blocked: release it"), "{lines:?}");
    assert!(!bench.device.outputs().amplifier && bench.device.outputs().fault.is_none());
    // near a stop, which a referenced device knows
    let mut bench = Bench::new(RigConfig { start_position: 0.0140, ..RigConfig::free_handle() }, 3);
    bench.device.home().expect("both stops");
    bench.say("sim hand at 0.014");
    bench.run(1_000);
    bench.say("sim hand off");
    bench.run(300);
    let answer = bench.say("selftest");
    println!("{answer}");
    assert!(answer.starts_with("err NO_ROOM: "), "{answer}");
}

#[test]
fn a_rig_that_is_right_passes_with_every_seed() {
    let mut passed = 0;
    for seed in 0..20 {
        for block in [None, Some(materials::BRASS), Some(materials::RUBBER)] {
            let mut bench = Bench::new(RigConfig::free_handle(), seed);
            bench.say("zero");
            if let Some(material) = block {
                bench.device.set_block(material.mass, material.law, &[]).expect("printed parameters");
            }
            let lines = bench.ask("selftest");
            assert!(lines[0].starts_with("ok selftest passed"), "{lines:#?}");
            passed += 1;
        }
    }
    println!("{passed} of 60 passed");
}

#[test]
fn weights_calibrate_the_load_cell() {
    let free = RigConfig::free_handle();
    let load = Sensor { gain: 1.08, offset: 0.9, ..free.load };
    let accel = Sensor { gain: 0.94, offset: -3.0, ..free.accel };
    let mut bench = Bench::new(RigConfig { load, accel, ..free }, 5);
    for weight in ["0", "4.905", "9.81"] {
        bench.say(&format!("sim hang {weight}"));
        let answer = bench.say(&format!("calibrate load {weight}"));
        println!("{answer}");
        assert!(answer.starts_with("ok calibrate load "), "{answer}");
    }
    bench.say("sim hang 0");
    for (tilt, value) in [("up", "9.80665"), ("down", "-9.80665")] {
        bench.say(&format!("sim tilt {tilt}"));
        println!("{}", bench.say(&format!("calibrate accel {value}")));
    }
    bench.say("sim tilt level");
    let saved = bench.say("calibrate save");
    println!("{saved}");
    assert!(saved.starts_with("ok calibrate; load: "), "{saved}");
    let device = bench.device.device();
    let gain = |after: &str| -> f64 {
        let text = saved.split(after).nth(1).and_then(|rest| rest.split_whitespace().next());
        text.and_then(|text| text.parse().ok()).unwrap_or(f64::NAN)
    };
    let load_error = gain("load: ") * 1.08 / f64::from(device.sheet.load.unit_per_code) - 1.0;
    let accel_error = gain("accel: ") * 0.94 / f64::from(device.sheet.accel.unit_per_code) - 1.0;
    println!("gain off by {:.3} % and {:.3} %", 100.0 * load_error, 100.0 * accel_error);
    assert!(load_error.abs() < 0.003 && accel_error.abs() < 0.01);
    bench.say("sim hang 5");
    bench.run(50);
    let status = bench.say("status");
    let reads: f64 = status
        .split("load ")
        .nth(1)
        .and_then(|rest| rest.split_whitespace().next())
        .and_then(|text| text.parse().ok())
        .unwrap_or(f64::NAN);
    println!("5 N hang on it: {reads} N");
    assert!((reads - 5.0).abs() < 0.3);
}

#[test]
fn bad_calibration_points_are_refused() {
    let mut bench = Bench::new(RigConfig::free_handle(), 5);
    let refuse = |bench: &mut Bench, command: &str, expected: &str| {
        let answer = bench.say(command);
        println!("{command:<28} {answer}");
        assert!(answer.starts_with(&format!("err {expected}")), "{command}: {answer}");
    };
    refuse(&mut bench, "calibrate", "SYNTAX: missing word");
    refuse(&mut bench, "calibrate load", "SYNTAX: missing word");
    refuse(&mut bench, "calibrate load NaN", "VALUE: VALUE = `NaN`");
    refuse(&mut bench, "calibrate save", "CALIBRATION: load: needs two points with different values");
    bench.say("calibrate load 0");
    refuse(&mut bench, "calibrate load 5", "EQUAL: code 32");
    // a weight of 5 N told to be 10
    bench.say("sim hang 5");
    bench.say("calibrate load 10");
    refuse(&mut bench, "calibrate save", "CALIBRATION: load: gain 0.00271");
    bench.say("calibrate discard");
    bench.say("calibrate load -5");
    bench.say("sim hang 0");
    bench.say("calibrate load 0");
    refuse(&mut bench, "calibrate save", "CALIBRATION: load: the code runs against the sign of its gain");
    bench.say("calibrate discard");
    for (hung, told) in [("0", "0"), ("5", "5"), ("10", "11")] {
        bench.say(&format!("sim hang {hung}"));
        bench.say(&format!("calibrate load {told}"));
    }
    refuse(&mut bench, "calibrate save", "CALIBRATION: load: the point at 5 is ");
    bench.say("calibrate discard");
    bench.say("sim hang 0");
    bench.device.hold(Holder::to_and_fro(0.005, 1.0));
    refuse(&mut bench, "calibrate load 0", "NOT_AT_REST: the handle moved by ");
    bench.device.hold(Holder::Nobody);
    bench.say("sim wire load dead");
    bench.run(500);
    refuse(&mut bench, "calibrate load 0", "DEAD: code 32768 without any noise");
    bench.say("render on");
    refuse(&mut bench, "calibrate load 0", "BUSY: ");
    // nothing was taken over
    assert!(bench.say("calibrate status").contains("load: 0.0013574 N per code, zero at 32768.0"));
}
