//! An encoder that falls silent is found, and one that has nothing to say is not accused.
#![cfg(not(target_os = "none"))]

use haptics::{FaultKind, ModeId};
use plant::{HandForce, HandImpedance, RigConfig, Sensor, Target};
use tribos_firmware::board::simulated::Holder;
use tribos_firmware::{VirtualConfig, VirtualDevice};

/// Says a command; the device has some milliseconds to obey.
fn say(device: &mut VirtualDevice, command: &str) {
    device.write(format!("{command}\n").as_bytes());
    for _ in 0..10 {
        device.tick();
    }
}

/// Rigs with good sensors and with bad ones.
fn rigs() -> Vec<(&'static str, RigConfig)> {
    let good = RigConfig::free_handle();
    let sensor = |gain, offset| Sensor { gain, offset, ..good.accel };
    let load = |gain, offset| Sensor { gain, offset, ..good.load };
    vec![
        ("good sensors", good),
        (
            "accelerometer +1 g, load cell +1.5 N",
            RigConfig { accel: sensor(1.0, 9.8), load: load(1.0, 1.5), ..good },
        ),
        (
            "accelerometer -1 g, 20 % too much",
            RigConfig { accel: sensor(1.2, -9.8), load: load(0.8, -1.5), ..good },
        ),
        (
            "own friction, loud sensors",
            RigConfig {
                device_friction_p: 1.04,
                device_friction_n: 0.69,
                accel: Sensor { noise: 1.0, ..good.accel },
                load: Sensor { noise: 0.3, ..good.load },
                ..good
            },
        ),
    ]
}

/// Hands from none at all to one that leans on the end of the stroke.
fn hands() -> Vec<(&'static str, Holder)> {
    let stiff = |target| Holder::Hand(HandImpedance { mass: 0.2, stiffness: 3e3, damping: 30.0, target });
    let sine = |amplitude, frequency| Target::Sine { centre: 0.0, amplitude, frequency };
    vec![
        ("nobody", Holder::Nobody),
        ("holds still", Holder::Hand(HandImpedance::relaxed(Target::Hold { position: 0.002 }))),
        ("pushes with 1 N", Holder::Force(HandForce::Steps(vec![(0.5, 1.0)]))),
        ("tugs", Holder::Force(HandForce::Sine { amplitude: 1.2, frequency: 7.0, offset: 0.0 })),
        ("to and fro, 8 mm at 0.5 Hz", stiff(sine(0.008, 0.5))),
        ("fast, 4 mm at 3 Hz", stiff(sine(0.004, 3.0))),
        ("trembles, 0.1 mm at 9 Hz", stiff(sine(0.0001, 9.0))),
        ("creeps, 0.2 mm/s", stiff(Target::Ramp { start: 0.0, velocity: 0.0002 })),
        ("leans on the stop", Holder::Force(HandForce::Ramp { rate: 3.0, from: 0.2, limit: 12.0 })),
        ("knocks with 60 N for 2 ms, three times a second", Holder::Force(knocks(60.0))),
        ("bangs on both stops", stiff(sine(0.019, 0.7))),
    ]
}

/// Blows to and fro.
fn knocks(force: f64) -> HandForce {
    let blow = |k: u32| {
        let (at, side) = (f64::from(k) / 3.0, if k.is_multiple_of(2) { 1.0 } else { -1.0 });
        [(at, side * force), (at + 0.002, 0.0)]
    };
    HandForce::Steps((1..18).flat_map(blow).collect())
}

/// What one run gave.
struct Run {
    fault: Option<FaultKind>,
    worst: f32,
}

fn run(device: &mut VirtualDevice, periods: u32) -> Run {
    let constants = device.device();
    // three samples must agree
    let (mut worst, mut last) = (0.0_f32, [0.0_f32; 3]);
    for k in 0..periods as usize {
        device.tick();
        last[k % 3] = device.state().unseen_motion(&constants);
        worst = worst.max(last[0].min(last[1]).min(last[2]));
    }
    Run { fault: device.outputs().fault, worst }
}

fn device(rig: RigConfig, seed: u64) -> VirtualDevice {
    let mut device = VirtualDevice::new(&VirtualConfig { seed, rig }).expect("a rig");
    // the offsets of the sensors are learned meanwhile
    for _ in 0..500 {
        device.tick();
    }
    say(&mut device, "zero");
    device
}

#[test]
fn hands_on_presets_are_no_dead_encoder() {
    for (rig_name, rig) in rigs() {
        let (mut worst, mut at, mut runs) = (0.0_f32, String::new(), 0);
        for preset in ["brass", "teflon", "rubber", "viscous"] {
            for (hand_name, hand) in hands() {
                let mut device = device(rig, runs + 1);
                say(&mut device, &format!("preset use {preset}"));
                say(&mut device, "render on");
                device.hold(hand);
                let run = run(&mut device, 6_000);
                assert_ne!(run.fault, Some(FaultKind::EncoderSilent), "{rig_name}, {preset}, {hand_name}");
                runs += 1;
                if run.worst > worst {
                    (worst, at) = (run.worst, format!("{preset}, hand {hand_name}"));
                }
            }
        }
        println!(
            "{rig_name}: {runs} runs of 6 s, no alarm; nearest {:.0} % of the bound ({at})",
            100.0 * worst
        );
        assert!(worst < 0.8, "too near");
    }
}

#[test]
fn block_motion_is_no_dead_encoder() {
    for (rig_name, rig) in rigs() {
        let (mut worst, mut at, mut runs) = (0.0_f32, String::new(), 0);
        for block in ["none", "brass", "teflon", "rubber"] {
            for motion in [
                "sine 0.01 2",
                "sine 0.001 8",
                "sine 0.012 0.05",
                "multisine 0.008 0.7",
                "chirp 0.002 6",
                "triangle 0.01 1",
                "dwell 0.01 1",
            ] {
                let mut device = device(rig, runs + 1);
                say(&mut device, &format!("sim block {block}"));
                say(&mut device, &format!("move {motion} 8"));
                assert_eq!(device.mode(), ModeId::Exciting, "{motion}");
                let run = run(&mut device, 10_000);
                assert_ne!(run.fault, Some(FaultKind::EncoderSilent), "{rig_name}, {block}, {motion}");
                runs += 1;
                if run.worst > worst {
                    (worst, at) = (run.worst, format!("block {block}, move {motion}"));
                }
            }
        }
        println!(
            "{rig_name}: {runs} runs of 10 s, no alarm; nearest {:.0} % of the bound ({at})",
            100.0 * worst
        );
        assert!(worst < 0.8, "too near");
    }
}

#[test]
fn early_motion_is_no_dead_encoder() {
    // the offsets of the sensors were once summed up as motion until they were learned
    let mut worst = 0.0_f32;
    for (_, rig) in rigs() {
        for seed in 0..25 {
            let mut device = VirtualDevice::new(&VirtualConfig { seed, rig }).expect("a rig");
            say(&mut device, "sim block rubber");
            say(&mut device, "zero");
            say(&mut device, "move sine 0.005 2");
            let run = run(&mut device, 500);
            assert_eq!(run.fault, None, "seed {seed}");
            worst = worst.max(run.worst);
        }
    }
    println!("100 motions begun 20 ms after power-on: nearest {:.0} % of the bound", 100.0 * worst);
}

#[test]
fn a_pressed_block_is_no_dead_encoder() {
    let (_, rig) = rigs().swap_remove(3);
    let mut device = device(rig, 5);
    say(&mut device, "preset use rubber");
    say(&mut device, "set f_static 5");
    say(&mut device, "set k_vc 20000");
    say(&mut device, "render on");
    device.hold(Holder::Force(HandForce::Sine { amplitude: 2.0, frequency: 0.3, offset: 1.5 }));
    let run = run(&mut device, 60_000);
    println!("stuck under -0.5 to 3.5 N for 60 s: nearest {:.0} % of the bound", 100.0 * run.worst);
    assert_eq!((run.fault, device.mode()), (None, ModeId::Rendering));
}

#[test]
fn a_dead_encoder_is_found_while_force_is_on() {
    println!("{:<38} {:>10} {:>12} {:>10}", "encoder dies while", "after, ms", "moved, mm", "mm/s then");
    for (block, motion) in [
        ("none", "sine 0.01 2"),
        ("rubber", "sine 0.01 2"),
        ("brass", "sine 0.004 3"),
        ("none", "triangle 0.01 1"),
    ] {
        let mut device = device(RigConfig::free_handle(), 3);
        say(&mut device, &format!("sim block {block}"));
        say(&mut device, &format!("move {motion}"));
        run(&mut device, 2_137);
        let found = die(&mut device);
        println!(
            "move {motion:<14} with block {block:<8} {:>10} {:>12.2} {:>10.0}",
            found.0, found.1, found.2
        );
        assert!(found.0 <= 60 && found.1 < 6.0);
    }
    for (preset, force) in [("teflon", 2.0), ("rubber", 6.0), ("brass", -4.0)] {
        let mut device = device(RigConfig::free_handle(), 3);
        say(&mut device, &format!("preset use {preset}"));
        say(&mut device, "render on");
        run(&mut device, 500);
        say(&mut device, "sim wire encoder dead");
        device.hold(Holder::Force(HandForce::Steps(vec![(0.0, force)])));
        let found = wait(&mut device);
        println!(
            "a hand pushes {preset:<8} with {force:>4} N        {:>10} {:>12.2} {:>10.0}",
            found.0, found.1, found.2
        );
        assert!(found.0 <= 60 && found.1 < 3.0);
    }
}

/// The encoder dies; see [`wait`].
fn die(device: &mut VirtualDevice) -> (u32, f64, f64) {
    device.write(b"sim wire encoder dead\n");
    device.tick();
    wait(device)
}

/// Periods until the fault, what the handle moved until then in mm, and its speed then in mm/s.
fn wait(device: &mut VirtualDevice) -> (u32, f64, f64) {
    let start = device.truth().position;
    let mut periods = 0;
    while device.outputs().fault.is_none() && periods < 1_000 {
        device.tick();
        periods += 1;
    }
    assert_eq!(device.outputs().fault, Some(FaultKind::EncoderSilent), "after {periods} ms");
    assert!(!device.outputs().amplifier && device.outputs().force == 0.0);
    (periods, 1e3 * (device.truth().position - start).abs(), 1e3 * device.truth().velocity.abs())
}
