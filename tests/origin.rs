//! The middle of the stroke: unknown after every start, found by `home` or told by `zero`, from anywhere in the stroke.
#![cfg(not(target_os = "none"))]

mod common;

use common::Bench;
use haptics::ModeId;
use link::Frame;
use plant::{HandImpedance, RigConfig, Target, Wire, Wiring, materials};
use tribos_firmware::VirtualDevice;
use tribos_firmware::board::simulated::{Holder, VirtualConfig};

/// Largest force of a search, N, and of a contact while unreferenced.
const SEARCH_N: f32 = 0.7 * 9.48;
const UNREFERENCED_N: f32 = 0.3 * 9.48;
/// Longest search, ms.
const LONGEST: u32 = 9_700;

/// What a search did.
struct Search {
    /// Its last line.
    told: String,
    took_ms: u32,
    /// Largest force, N, and largest true speed, m/s.
    force: f32,
    speed: f64,
}

/// Types `home` and watches the search to its end.
fn home(bench: &mut Bench) -> Search {
    let answer = bench.say("home");
    assert_eq!(answer, "ok home: slowly to both stops, hands off; the result follows");
    watch(bench)
}

fn watch(bench: &mut Bench) -> Search {
    let mut search = Search { told: String::new(), took_ms: 0, force: 0.0, speed: 0.0 };
    while search.told.is_empty() {
        assert!(search.took_ms <= LONGEST, "no end");
        for line in bench.run(1) {
            if ["! home: ", "! no home: ", "! fault "].iter().any(|begin| line.starts_with(begin)) {
                search.told = line;
            }
        }
        search.took_ms += 1;
        search.force = search.force.max(bench.device.outputs().force.abs());
        search.speed = search.speed.max(bench.device.truth().velocity.abs());
    }
    assert!(!bench.device.outputs().amplifier, "{}", search.told);
    search
}

/// Refuses everything that moves the handle, and says what to type.
fn is_unreferenced(bench: &mut Bench) {
    let status = bench.say("status");
    assert!(status.contains(", unreferenced, preset "), "{status}");
    for command in ["move sine 0.01 2 1", "identify", "selftest"] {
        let refused = bench.say(command);
        assert!(refused.starts_with("err UNREFERENCED: "), "{command}: {refused}");
        assert!(refused.contains("`home`") && refused.contains("`zero`"), "{refused}");
        assert!(!bench.device.outputs().amplifier);
    }
}

#[test]
fn home_finds_the_middle_from_anywhere() {
    let mut runs = 0;
    let (mut longest, mut strongest, mut fastest, mut off) = (0, 0.0_f32, 0.0_f64, 0.0_f64);
    for start in [-0.016, -0.0158, -0.012, -0.003, 0.0, 0.007, 0.012, 0.0159, 0.016] {
        for block in [None, Some(materials::TEFLON), Some(materials::BRASS), Some(materials::RUBBER)] {
            for friction in [(0.0, 0.0), (1.04, 0.69)] {
                let rig = RigConfig {
                    start_position: start,
                    device_friction_p: friction.0,
                    device_friction_n: friction.1,
                    ..RigConfig::free_handle()
                };
                let mut bench = Bench::new(rig, runs);
                if let Some(material) = block {
                    bench.device.set_block(material.mass, material.law, &[]).expect("printed parameters");
                }
                assert!(bench.device.outputs().position.abs() < 1e-4, "the count begins where the handle is");
                is_unreferenced(&mut bench);
                let search = home(&mut bench);
                let what = format!("from {start} m, block {:?}: {}", block.map(|b| b.name), search.told);
                assert!(search.told.starts_with("! home: stroke 32.0"), "{what}");
                bench.run(300);
                let (truth, told) = (bench.device.truth(), f64::from(bench.device.outputs().position));
                // the handle rests near the middle, and the device knows exactly where
                assert!(truth.position.abs() < 5e-4 && truth.velocity.abs() < 1e-3, "{what}: {truth:?}");
                assert!((told - truth.position).abs() < 2e-5, "{what}: {told}, truth {truth:?}");
                assert!(search.force <= SEARCH_N && search.speed < 0.1, "{what}");
                assert!(bench.device.outputs().referenced && bench.device.mode() == ModeId::Idle);
                let moves = bench.say("move sine 0.012 1 1");
                assert!(moves.starts_with("ok move"), "{what}: {moves}");
                bench.run(2_500);
                assert_eq!(bench.device.outputs().fault, None, "{what}");
                (longest, off) = (longest.max(search.took_ms), off.max((told - truth.position).abs()));
                (strongest, fastest) = (strongest.max(search.force), fastest.max(search.speed));
                runs += 1;
            }
        }
    }
    println!(
        "{runs} searches: middle within {:.1} um, at most {longest} ms, {strongest:.2} N, {:.0} mm/s",
        1e6 * off,
        1e3 * fastest
    );
}

#[test]
fn home_works_at_every_rate() {
    for rate in haptics::RATES {
        let mut bench = Bench::new(RigConfig { start_position: -0.011, ..RigConfig::free_handle() }, 2);
        assert!(bench.say(&format!("rate {rate}")).starts_with("ok rate"));
        let search = home(&mut bench);
        println!("{rate} Hz: {} ({} ms)", search.told, search.took_ms);
        assert!(search.told.starts_with("! home: stroke 32.0") && search.speed < 0.1, "{}", search.told);
        assert!(bench.device.truth().position.abs() < 5e-4);
    }
}

#[test]
fn an_unreferenced_device_renders_with_little_force() {
    let mut bench = Bench::new(RigConfig { start_position: 0.010, ..RigConfig::free_handle() }, 1);
    let largest = |bench: &mut Bench| {
        let from = bench.device.truth().position;
        let hand = HandImpedance {
            stiffness: 1_500.0,
            damping: 15.0,
            ..HandImpedance::relaxed(Target::Sine { centre: from, amplitude: 0.004, frequency: 1.0 })
        };
        bench.device.hold(Holder::Hand(hand));
        let mut largest = 0.0_f32;
        for _ in 0..2_000 {
            bench.run(1);
            largest = largest.max(bench.device.outputs().force.abs());
        }
        assert_eq!(bench.device.mode(), ModeId::Rendering);
        bench.device.hold(Holder::Nobody);
        largest
    };
    bench.say("preset use rubber");
    let warned = bench.say("render on");
    println!("{warned}");
    assert!(warned.starts_with("ok warn: unreferenced: at most 2.84 N; `home`"), "{warned}");
    let little = largest(&mut bench);
    // the whole stroke may be on either side of where the count began
    bench.device.hold(Holder::Hand(HandImpedance::relaxed(Target::Hold { position: -0.014 })));
    bench.run(1_000);
    assert!(bench.device.truth().position < -0.012);
    assert_eq!((bench.device.outputs().fault, bench.device.mode()), (None, ModeId::Rendering));
    bench.device.hold(Holder::Nobody);
    assert!(bench.say("zero").starts_with("err BUSY"), "the force would jump");
    bench.say("render off");
    bench.run(300);
    assert!(home(&mut bench).told.starts_with("! home"));
    assert_eq!(bench.say("render on"), "ok render on");
    let all = largest(&mut bench);
    println!("rubber, unreferenced: at most {little:.2} N; referenced: {all:.2} N");
    assert!(little <= UNREFERENCED_N && little > 0.99 * UNREFERENCED_N && all > 1.2 * UNREFERENCED_N);
}

#[test]
fn zero_is_where_the_hand_holds_the_handle() {
    let mut bench = Bench::new(RigConfig { start_position: 0.016, ..RigConfig::free_handle() }, 1);
    bench.device.hold(Holder::to_and_fro(0.005, 1.0));
    bench.run(350);
    let moving = bench.say("zero");
    println!("{moving}");
    assert!(moving.starts_with("err NOT_AT_REST: the handle moves"), "{moving}");
    is_unreferenced(&mut bench);
    bench.device.hold(Holder::Hand(HandImpedance::relaxed(Target::Hold { position: 0.0003 })));
    bench.run(1_500);
    assert_eq!(bench.say("zero"), "ok zero: the handle is in the middle of its stroke");
    bench.run(1);
    assert!(bench.device.outputs().position.abs() < 1e-5);
    assert!(!bench.say("status").contains("unreferenced"));
    bench.device.hold(Holder::Nobody);
    bench.run(300);
    assert!(bench.say("selftest").starts_with("ok selftest passed"));
    assert!(bench.say("move sine 0.01 2 1").starts_with("ok move"));
    let busy = bench.say("zero");
    assert!(busy.starts_with("err BUSY"), "{busy}");
    assert!(bench.say("home").starts_with("err BUSY"));
    bench.run(3_000);
    assert_eq!(bench.device.outputs().fault, None);
}

#[test]
fn stop_and_off_end_a_search_unreferenced() {
    for command in ["stop", "off"] {
        for after in (50..5_000).step_by(330) {
            let mut bench = Bench::new(RigConfig { start_position: 0.009, ..RigConfig::free_handle() }, 4);
            bench.say("home");
            bench.run(after);
            if bench.device.mode() != ModeId::Homing {
                continue;
            }
            bench.device.write(format!("{command}\n").as_bytes());
            bench.device.tick();
            bench.device.tick();
            assert!(!bench.device.outputs().amplifier && bench.device.outputs().force == 0.0);
            let said = bench.run(50);
            assert!(
                said.iter().any(|line| line == "! no home: interrupted; still unreferenced")
                    && said
                        .iter()
                        .any(|line| line.starts_with("ok ") && line.contains("the search has ended")),
                "{command} after {after} ms: {said:?}"
            );
            is_unreferenced(&mut bench);
            bench.run(500);
            assert!(home(&mut bench).told.starts_with("! home"), "a way on");
        }
    }
}

#[test]
fn a_fault_ends_a_search_unreferenced() {
    let mut bench = Bench::new(RigConfig::free_handle(), 4);
    bench.say("home");
    bench.run(700);
    bench.device.hold(Holder::Force(plant::HandForce::Steps(vec![(0.0, 40.0)])));
    let search = watch(&mut bench);
    println!("{}", search.told);
    assert!(search.told.contains("faster than a search"), "{}", search.told);
    is_unreferenced(&mut bench);
    // without a host that talks, a search ends by its fault
    let mut bench = Bench::new(RigConfig::free_handle(), 4);
    bench.say("watch 1");
    bench.say("home");
    let search = watch(&mut bench);
    assert!(search.told.starts_with("! fault host_silent"), "{}", search.told);
    assert!(bench.say("status").contains("fault, unreferenced"));
    bench.run(500);
    assert_eq!(bench.say("clear"), "ok clear");
    is_unreferenced(&mut bench);
}

#[test]
fn stops_at_another_place_are_reported() {
    for (stroke, start, says) in [
        (0.020, 0.0, "stops 20.0"),
        (0.020, 0.010, "stops 20.0"),
        (0.0305, -0.004, "stops 30.5"),
        (0.0335, 0.0, "no stop within 32.96 mm"),
        (0.050, -0.020, "no stop within 32.96 mm"),
        (0.050, 0.025, "no stop within 32.96 mm"),
    ] {
        let rig = RigConfig { stroke: Some(stroke), start_position: start, ..RigConfig::free_handle() };
        let mut bench = Bench::new(rig, 3);
        let search = home(&mut bench);
        println!("stroke {stroke} m, from {start} m: {}", search.told);
        assert!(search.told.starts_with("! no home: ") && search.told.contains(says), "{}", search.told);
        assert!(search.told.ends_with("; still unreferenced"));
        is_unreferenced(&mut bench);
    }
    // a little more or less is accepted, and measured
    for (stroke, says) in [(0.0314, "stroke 31.4"), (0.0327, "stroke 32.7")] {
        let mut bench = Bench::new(RigConfig { stroke: Some(stroke), ..RigConfig::free_handle() }, 3);
        let search = home(&mut bench);
        assert!(search.told.contains(says), "{}", search.told);
        assert!(bench.say("move sine 0.0149 0.5 2").starts_with("ok move"));
        bench.run(4_000);
        assert_eq!(bench.device.outputs().fault, None, "{stroke}");
    }
}

#[test]
fn wrong_wiring_ends_a_search_before_it_runs_away() {
    use Wire::{Dead, Swapped};
    let right = Wiring::default();
    for (what, wiring) in [
        ("encoder swapped", Wiring { encoder: Swapped, ..right }),
        ("encoder dead", Wiring { encoder: Dead, ..right }),
        ("amplifier swapped", Wiring { amplifier: Swapped, ..right }),
        ("amplifier dead", Wiring { amplifier: Dead, ..right }),
    ] {
        for start in [-0.012, 0.0, 0.012] {
            let rig = RigConfig { wiring, start_position: start, ..RigConfig::free_handle() };
            let mut bench = Bench::new(rig, 3);
            let search = home(&mut bench);
            println!("{what}, from {start} m: {:.0} mm/s, {}", 1e3 * search.speed, search.told);
            assert!(!search.told.starts_with("! home"), "{what}: {}", search.told);
            assert!(search.force <= SEARCH_N && search.speed < 0.25, "{what}: {} m/s", search.speed);
            assert!(bench.say("status").contains("unreferenced"), "{what}");
        }
    }
}

#[test]
fn a_held_handle_is_no_stop_of_the_stroke() {
    let mut bench = Bench::new(RigConfig { start_position: 0.003, ..RigConfig::free_handle() }, 3);
    bench.device.hold(Holder::Hand(HandImpedance {
        mass: 0.3,
        stiffness: 5e3,
        damping: 50.0,
        target: Target::Hold { position: 0.003 },
    }));
    let search = home(&mut bench);
    println!("{}", search.told);
    assert!(search.told.starts_with("! no home: stops 2."), "{}", search.told);
    is_unreferenced(&mut bench);
}

#[test]
fn a_restart_in_mid_stroke_forgets_the_origin() {
    let mut bench = Bench::new(RigConfig { start_position: 0.004, ..RigConfig::free_handle() }, 3);
    assert!(home(&mut bench).told.starts_with("! home"));
    assert!(bench.say("move sine 0.012 0.5").starts_with("ok move"));
    bench.run(1_600);
    let left_at = bench.device.truth().position;
    assert!(left_at.abs() > 0.005, "{left_at}");
    let flash = bench.device.power_off();
    let rig = RigConfig { start_position: left_at, ..RigConfig::free_handle() };
    let device = VirtualDevice::with_flash(&VirtualConfig { seed: 4, rig }, flash).expect("a rig");
    let mut bench = Bench::new(rig, 4);
    bench.device = device;
    bench.run(50);
    assert!(bench.device.outputs().position.abs() < 1e-4, "the counter begins at zero");
    is_unreferenced(&mut bench);
    assert!(home(&mut bench).told.starts_with("! home: stroke 32.0"));
    bench.run(1);
    let told = f64::from(bench.device.outputs().position);
    assert!((told - bench.device.truth().position).abs() < 2e-5);
}

#[test]
fn a_stream_tells_the_origin_and_the_state() {
    let mut bench = Bench::new(RigConfig { start_position: -0.007, ..RigConfig::free_handle() }, 3);
    bench.say("stream on");
    let search = home(&mut bench);
    assert!(search.told.starts_with("! home"), "{}", search.told);
    bench.run(300);
    let headers: Vec<_> = bench
        .frames
        .iter()
        .enumerate()
        .filter_map(|(at, (_, frame))| match frame {
            Frame::Header(header) => Some((at, header.clone())),
            Frame::Sample(_) => None,
        })
        .collect();
    assert_eq!(headers.len(), 2, "one at the start, one with the origin");
    let (at, header) = &headers[1];
    assert_eq!(headers[0].1.origin_count, 0);
    for (k, (_, frame)) in bench.frames.iter().enumerate() {
        if let Frame::Sample(sample) = frame {
            assert_eq!(sample.referenced, k > *at, "sample {k}, header {at}");
            assert!(sample.mode == 0 || !sample.referenced && sample.mode == ModeId::Homing.code());
        }
    }
    let Some((seq, Frame::Sample(last))) = bench.frames.last() else { panic!("samples") };
    assert_eq!(*seq as usize, bench.frames.len() - 1 - at, "numbered from the new header");
    let told = f64::from(last.count.wrapping_sub(header.origin_count)) * f64::from(header.metre_per_count);
    println!(
        "origin at count {}: {told:.6} m, truth {:.6} m",
        header.origin_count,
        bench.device.truth().position
    );
    assert!((told - bench.device.truth().position).abs() < 2e-5);
}
