//! An hour of random commands, faults, resets and power cuts on the virtual device. After each: the force is within its limits, no
//! preset is lost, and every state has the way out that it states.
#![cfg(not(target_os = "none"))]

mod common;
#[path = "common/typist.rs"]
mod typist;

use common::Bench;
use emulator::random::Random;
use haptics::{DEVICE_SETTINGS, Device, ModeId};
use plant::RigConfig;
use std::collections::BTreeMap;
use tribos_firmware::board::simulated::{VirtualConfig, VirtualDevice};
use typist::line;

/// What a run must find again: the saved presets.
type Shelf = BTreeMap<String, Vec<String>>;

struct Run {
    bench: Bench,
    shelf: Shelf,
    seed: u64,
    log: Vec<String>,
    milliseconds: u64,
}

impl Run {
    fn new(seed: u64) -> Self {
        let mut run = Self {
            bench: Bench::new(RigConfig::free_handle(), seed),
            shelf: Shelf::new(),
            seed,
            log: Vec::new(),
            milliseconds: 0,
        };
        for (name, command) in [("a", "set f_static 1.9"), ("b", "set damping 3")] {
            run.ask("preset use brass");
            run.ask(command);
            run.ask(&format!("preset save {name}"));
            let shown = run.ask(&format!("preset show {name}"));
            run.shelf.insert(name.into(), shown);
        }
        run
    }

    /// Fails with the last commands, to be typed again.
    fn fail(&self, what: &str) -> ! {
        let from = self.log.len().saturating_sub(40);
        panic!("seed {}, {} ms: {what}\n{}", self.seed, self.milliseconds, self.log[from..].join("\n"));
    }

    /// Advances, and checks every period.
    fn pass(&mut self, ms: u32) -> Vec<String> {
        let mut lines = Vec::new();
        for _ in 0..ms {
            lines.extend(self.bench.run(1));
            self.milliseconds += 1;
            let (outputs, device) = (*self.bench.device.outputs(), self.bench.device.device());
            let most = match outputs.mode {
                _ if !outputs.amplifier => 0.0,
                ModeId::Rendering if !outputs.referenced => device.unreferenced_force(),
                _ => device.force_max,
            };
            if !(outputs.force.abs() <= most) || !outputs.position.is_finite() {
                self.fail(&format!("{outputs:?}, at most {most} N"));
            }
            if !outputs.referenced && outputs.mode.is_driven() && outputs.mode != ModeId::Homing {
                self.fail("driven while unreferenced");
            }
        }
        for line in &lines {
            self.log.push(format!("    {line}"));
        }
        lines
    }

    /// Types a line and waits for its answer.
    fn ask(&mut self, command: &str) -> Vec<String> {
        self.log.push(command.to_owned());
        self.bench.device.write(format!("{command}\n").as_bytes());
        let mut lines = Vec::new();
        for _ in 0..4_000 {
            lines.extend(self.pass(1));
            let Some(at) = lines.iter().position(|line| link::reply::is_answer(line)) else { continue };
            let end = at + 1 + link::reply::lines_to_follow(&lines[at]);
            if lines.len() >= end {
                return lines[at..end].to_vec();
            }
        }
        self.fail(&format!("`{command}` was not answered"));
    }

    fn say(&mut self, command: &str) -> String {
        self.ask(command).swap_remove(0)
    }

    /// Power goes and comes back.
    fn cut(&mut self) {
        self.log.push("-- power cut".into());
        let before = self.bench.device.device();
        let config = VirtualConfig { seed: self.seed, rig: RigConfig::free_handle() };
        let old = VirtualDevice::new(&config).expect("the rig");
        let flash = std::mem::replace(&mut self.bench.device, old).power_off();
        match VirtualDevice::with_flash(&config, flash) {
            Ok(device) => self.bench.device = device,
            Err(why) => self.fail(&format!("does not start: {why}")),
        }
        self.bench.forget_line();
        self.pass(100);
        let outputs = self.bench.device.outputs();
        let after = self.bench.device.device();
        let kept = DEVICE_SETTINGS.iter().all(|setting| before.get(setting.name) == after.get(setting.name));
        if !kept || (before.load, before.accel, before.command) != (after.load, after.accel, after.command) {
            self.fail(&format!("device {before:?}, after the start {after:?}"));
        }
        if outputs.mode != ModeId::Idle || outputs.referenced || outputs.amplifier {
            self.fail(&format!("after a start: {outputs:?}"));
        }
    }

    /// Nothing saved is lost, unless the device is another one.
    fn check_presets(&mut self) {
        for (name, shown) in self.shelf.clone() {
            let found = self.ask(&format!("preset show {name}"));
            if found != shown {
                self.fail(&format!("preset {name}: {found:?}, saved {shown:?}"));
            }
        }
    }

    /// The way out that the book states: `off`, hands off, wiring right, `clear`, `device reset`, `home`; then it renders.
    fn way_out(&mut self) {
        self.log.push("-- way out".into());
        for wire in ["encoder", "load", "accel", "amplifier", "command"] {
            self.say(&format!("sim wire {wire} right"));
        }
        for command in [
            "off",
            "stream off",
            "sim hand off",
            "sim block none",
            "sim tilt level",
            "sim hang 0",
            "calibrate discard",
        ] {
            self.say(command);
        }
        // offsets of the checks are learnt again, and the motor cools
        self.pass(3_000);
        let mut cleared = self.say("clear");
        if cleared.starts_with("err OUTSIDE_STROKE: ") {
            // as it says: by hand
            self.say("sim hand at 0");
            self.pass(1_000);
            self.say("sim hand off");
            self.pass(500);
            cleared = self.say("clear");
        }
        if cleared.starts_with("err NOT_AT_REST: ") || cleared.starts_with("err OUTSIDE_STROKE: ") {
            // as it says: load cell, stroke or resolution are set wrong
            self.say("device reset");
            cleared = self.say("clear");
        }
        if cleared != "ok clear" {
            let fault = self.say("fault");
            self.fail(&format!("no way out of the fault: {cleared}, {fault}"));
        }
        for command in ["watch 30", "device reset", "preset use brass", "rate 1000"] {
            let said = self.say(command);
            if !said.starts_with("ok") {
                self.fail(&format!("{command}: {said}"));
            }
        }
        let said = self.say("home");
        if !said.starts_with("ok") {
            self.fail(&format!("home: {said}"));
        }
        let mut heard = Vec::new();
        for _ in 0..30 {
            heard.extend(self.pass(500));
            if heard.iter().any(|line| line.starts_with("! ")) {
                break;
            }
        }
        if !heard.iter().any(|line| line.starts_with("! home")) {
            self.fail(&format!("home: {heard:?}"));
        }
        for command in ["render on", "render off"] {
            let said = self.say(command);
            if !said.starts_with("ok render") {
                self.fail(&format!("{command}: {said}"));
            }
        }
    }
}

/// Random commands for this time.
fn run(seed: u64, seconds: u64) {
    let mut random = Random(seed);
    let mut run = Run::new(seed);
    let (mut commands, mut obeyed, mut cuts, mut faults) = (0, 0, 0, 0);
    while run.milliseconds < 1_000 * seconds {
        for _ in 0..60 {
            let typed = line(&mut random);
            commands += 1;
            // an empty line has no answer
            if typed.trim().is_empty() {
                continue;
            }
            obeyed += u32::from(run.say(&typed).starts_with("ok"));
            let longest = if random.below(8) == 0 { 3_000 } else { 120 };
            run.pass(random.below(longest) as u32);
            faults += u32::from(run.bench.device.mode() == ModeId::Fault);
            if random.below(40) == 0 {
                run.cut();
                cuts += 1;
            }
        }
        run.way_out();
        run.check_presets();
    }
    println!(
        "seed {seed}: {commands} commands, {obeyed} obeyed, {faults} times in a fault, {cuts} power cuts, {} s",
        run.milliseconds / 1_000
    );
    assert!(cuts > 0 && faults > 0 && obeyed > commands / 4);
    assert_eq!(run.bench.device.device().stroke, Device::default().stroke);
}

#[test]
fn random_commands_leave_a_way_out() {
    // an hour in all
    for seed in 1..=20 {
        run(seed, 180);
    }
}

/// Found by random commands: the frames kept the buffer of the line full, and no command was read any more.
#[test]
fn a_stream_that_fills_the_line_can_be_ended() {
    let mut bench = Bench::new(RigConfig::free_handle(), 1);
    assert!(bench.say("rate 20000").starts_with("ok"));
    assert!(bench.say("stream on 1").starts_with("ok"));
    bench.run(500);
    assert_eq!(bench.say("get dv"), "ok dv 0.007 m/s");
    assert!(bench.ask("help").len() > 30);
    let said = bench.say("stream off");
    println!("{said}");
    assert!(said.starts_with("ok stream off, "));
}

/// Found by random commands: with a gain far too large the noise of the load cell was a load, which `clear` refused, and
/// `device` waited for `clear`.
#[test]
fn a_fault_leaves_the_settings_of_the_device() {
    let mut bench = Bench::new(RigConfig::free_handle(), 1);
    assert!(bench.say("device set load_gain 9000").starts_with("ok"));
    assert!(bench.say("render on").starts_with("ok"));
    bench.say("sim wire load dead");
    bench.run(1_000);
    bench.say("sim wire load right");
    bench.run(500);
    assert_eq!(bench.device.mode(), ModeId::Fault);
    let refused = bench.say("clear");
    println!("{refused}");
    assert!(refused.starts_with("err NOT_AT_REST: ") && refused.contains("`device`"), "{refused}");
    assert!(bench.say("device reset").starts_with("ok"));
    assert_eq!(bench.device.mode(), ModeId::Fault);
    assert_eq!(bench.say("clear"), "ok clear");
}
