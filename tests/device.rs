//! A device that is not the rig of [thesis, table 3-1], by its settings alone: no build knows it.
#![cfg(not(target_os = "none"))]

mod common;

use common::Bench;

use plant::{HandForce, RigConfig};
use tribos_firmware::board::simulated::Holder;

/// A knob: 2 rad between its stops, 8192 counts a turn that count backwards, 0.2 N·m, a reversed amplifier and load cell.
const KNOB: &str = "geometry rotary stroke 2 resolution -0.00076699 mass 0.0001 damping 0.001 overspeed 60 \
                    force_max 0.2 force_gain -0.15 load_gain -0.3 accel_gain 2000";

fn last(lines: &[String]) -> &str {
    lines.iter().map(String::as_str).rfind(|line| line.starts_with('!')).unwrap_or("")
}

/// The knob, with a firmware that was told.
fn knob() -> Bench {
    let mut bench = Bench::new(RigConfig::free_handle(), 1);
    println!("{}", bench.say(&format!("sim device {KNOB}")));
    bench.run(100);
    let said = bench.say(&format!("device set {KNOB}"));
    println!("{said}");
    assert!(said.starts_with("ok device"), "{said}");
    bench
}

#[test]
fn a_knob_homes_renders_and_identifies() {
    let mut bench = knob();
    for line in bench.ask("device") {
        println!("{line}");
    }
    println!("{}", bench.say("status"));
    println!("{}", bench.say("home"));
    let heard = bench.run(20_000);
    println!("{}", last(&heard));
    assert!(last(&heard).starts_with("! home: stroke 2.0"), "{heard:?}");
    assert!(last(&heard).contains(" rad,"));
    assert!(bench.device.truth().position.abs() < 0.03);
    for line in bench.ask("selftest") {
        println!("{line}");
        assert!(!line.contains("FAIL"), "{line}");
    }
    // a contact that sticks: below its static friction it holds, above it slides
    for command in ["set dv 0.5", "set f_static 0.05", "set f_dynamic 0.04", "render on"] {
        let said = bench.say(command);
        println!("{said}");
        assert!(said.starts_with("ok"), "{said}");
    }
    let now = bench.device.truth().time;
    bench.device.hold(Holder::Force(HandForce::Steps(vec![(0.0, 0.0), (now, 0.03), (now + 1.0, 0.08)])));
    bench.run(300);
    let before = bench.device.truth().position;
    bench.run(600);
    let held = bench.device.truth().position - before;
    bench.run(300);
    let slid = bench.device.truth().position - before;
    println!("0.03 N·m: {held:.4} rad, 0.08 N·m: {slid:.4} rad; {}", bench.say("status"));
    assert!(held.abs() < 0.005 && slid > 0.1);
    bench.device.hold(Holder::Nobody);
    println!("{}", bench.say("stop"));
    println!("{}", bench.say("home"));
    println!("{}", last(&bench.run(20_000)));
    // a real block on it: brass, at the scale of the knob
    println!("{}", bench.say("sim block brass"));
    println!("{}", bench.say("identify"));
    let heard = bench.run(14_000);
    let found =
        heard.iter().find(|line| line.starts_with("! identified")).unwrap_or_else(|| panic!("{heard:?}"));
    println!("{found}");
    let number = |name: &str| -> (f64, f64) {
        let mut words = found.split(&format!(" {name} ")).nth(1).expect("in the line").split(' ');
        let value = words.next().expect("a value").parse().expect("a number");
        assert_eq!(words.next(), Some("±"));
        (value, words.next().expect("a deviation").parse().expect("a number"))
    };
    let (force, inertia) = (0.2 / 9.48, 1e-4 / 0.692);
    let brass = plant::materials::BRASS;
    for (name, truth) in
        [("mass", inertia * brass.mass), ("C_p", force * brass.law.c_p), ("C_n", force * brass.law.c_n)]
    {
        let (value, std) = number(name);
        println!("{name} {value} ± {std}, true {truth:.7}");
        assert!((value - truth).abs() < 4.0 * std && std < 0.05 * truth, "{name}");
    }
    assert!(found.contains("kg·m²") && found.contains("N·m"));
}

/// They were in newtons and metres, whatever the device.
#[test]
fn limits_and_refusals_of_a_knob_are_in_its_units() {
    let mut bench = knob();
    for (command, expected) in [
        ("limit", "unexplained_force 0.0738"),
        ("limit continuous_force 0.1", "ok limit continuous_force 0.1 N·m"),
        ("limit heating 50", "ok limit heating 50 s"),
        ("limit continuous_force 5", "; N·m; up to the actuator's force"),
        ("set dv 1e9", "; rad/s; treated as zero below it"),
        ("device set load_gain 1e9", "; N·m/V; either sign; "),
        ("move sine 9 1", "; rad; 3 % inside the stroke"),
    ] {
        let said = bench.say(command);
        println!("{said}");
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn the_load_cell_of_a_knob_calibrates_its_force() {
    let mut bench = knob();
    println!("{}", bench.say("sim device force_gain -0.157"));
    bench.run(200);
    bench.say("zero");
    bench.say("sim hand at 0");
    println!("{}", bench.say("calibrate force"));
    let heard = bench.run(13_000);
    let said = last(&heard);
    println!("{said}");
    assert!(said.starts_with("! calibrate; "), "{heard:?}");
    let gain =
        bench.device.device().command.unit_per_code / bench.device.device().sheet.command.unit_per_code;
    assert!((gain / (0.157 / 0.15) - 1.0).abs() < 0.003, "{gain}");
}
