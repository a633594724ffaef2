//! Feed-forward of the device's own friction: what a hand feels of it, and whether the handle rests.
#![cfg(not(target_os = "none"))]

mod common;

use common::Bench;
use plant::{HandImpedance, RigConfig, Target};
use tribos_firmware::board::simulated::Holder;

/// The friction of [thesis, table 3-1], N.
const FRICTION: (f64, f64) = (1.04, 0.69);
/// Travel of one count, m.
const COUNT: f64 = 2.57e-6;

/// A device with its own friction that renders nothing, referenced.
fn bench(rig: RigConfig, seed: u64) -> Bench {
    let (device_friction_p, device_friction_n) = FRICTION;
    let mut bench = Bench::new(RigConfig { device_friction_p, device_friction_n, ..rig }, seed);
    bench.say("home");
    for _ in 0..100 {
        if bench.run(100).iter().any(|line| line.starts_with("! home")) {
            break;
        }
    }
    for line in
        ["renderer impedance", "f_dynamic 0", "f_static 0", "damping 0", "dv 0.0001", "k_vc 8000", "b_vc 15"]
    {
        let _ = bench.say(&format!("set {line}"));
    }
    for line in ["f_static 0", "f_dynamic 0", "f_static 0"] {
        let answer = bench.say(&format!("set {line}"));
        assert!(answer.starts_with("ok"), "{answer}");
    }
    bench
}

const COMPENSATE: &str = "compensate friction_p 1.04 friction_n 0.69 damping 6.9";

/// Force of the hand while the handle slides, N, without that for its mass: means forward and back.
fn felt(bench: &mut Bench) -> [f64; 2] {
    bench.device.hold(Holder::Hand(HandImpedance {
        stiffness: 1_500.0,
        damping: 15.0,
        ..HandImpedance::relaxed(Target::Sine { centre: 0.0, amplitude: 0.008, frequency: 0.5 })
    }));
    bench.run(1_000);
    let mut sums = [(0.0, 0.0); 2];
    for _ in 0..6_000 {
        bench.run(1);
        let t = bench.device.truth();
        if t.velocity.abs() > 5e-3 {
            let moving = t.hand_force - 0.692 * t.acceleration;
            let sum = &mut sums[usize::from(t.velocity < 0.0)];
            *sum = (sum.0 + moving * t.velocity.signum(), sum.1 + 1.0);
        }
    }
    sums.map(|(sum, n)| sum / n)
}

/// Push at which the handle breaks away, N, in both directions: slow ramps from rest, 0.5 N/s.
fn break_away(bench: &mut Bench) -> [f64; 2] {
    [1.0, -1.0].map(|sign| {
        bench.device.hold(Holder::Hand(HandImpedance {
            stiffness: 1_500.0,
            damping: 60.0,
            ..HandImpedance::relaxed(Target::Hold { position: 0.0 })
        }));
        bench.run(1_500);
        bench.device.hold(Holder::Nobody);
        bench.run(500);
        let begin = bench.device.truth();
        bench.device.hold(Holder::Force(plant::HandForce::Ramp {
            rate: sign * 0.5,
            from: begin.time,
            limit: 3.0,
        }));
        for _ in 0..6_000 {
            bench.run(1);
            let t = bench.device.truth();
            if (t.position - begin.position).abs() > 20.0 * COUNT {
                return t.hand_force * sign;
            }
        }
        f64::NAN
    })
}

/// Peak to peak of the true position over two seconds, counts: released, held, held off the middle.
fn rests(bench: &mut Bench) -> [f64; 3] {
    let hand = |k: f64, b: f64, position: f64| {
        Holder::Hand(HandImpedance {
            stiffness: k,
            damping: b,
            ..HandImpedance::relaxed(Target::Hold { position })
        })
    };
    [Holder::Nobody, hand(400.0, 6.0, 0.002), hand(1_500.0, 15.0, 0.003)].map(|hand| {
        bench.device.hold(hand);
        bench.run(1_500);
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for _ in 0..2_000 {
            bench.run(1);
            let x = bench.device.truth().position;
            (low, high) = (low.min(x), high.max(x));
        }
        (high - low) / COUNT
    })
}

#[test]
fn the_friction_of_the_device_is_felt_down_to_a_tenth() {
    for seed in 1..6 {
        let mut b = bench(RigConfig::free_handle(), seed);
        b.say("render on");
        let before = (felt(&mut b), break_away(&mut b));
        let answer = b.say(COMPENSATE);
        assert!(answer.starts_with("ok compensate share 0.9, friction_p 1.04 N, "), "{answer}");
        let (slides, breaks, rested) = (felt(&mut b), break_away(&mut b), rests(&mut b));
        println!("before {before:.3?}; after {slides:.3?}, {breaks:.3?}; rests within {rested:.2?} counts");
        // with the damping at 16 mm/s on average: 0.13 N before, 0.01 N after
        assert!((before.0[0] - 1.17).abs() < 0.03 && slides.iter().all(|felt| (0.05..0.15).contains(felt)));
        assert!(before.1[0] > 0.95 && breaks.iter().all(|felt| (0.0..0.2).contains(felt)));
        assert!(rested.iter().all(|counts| *counts < 1.0), "a limit cycle");
        assert_eq!(b.say("fault"), "ok no fault");
    }
}

/// By velocity alone a handle breaks away at all of its friction: the push of the hand is what removes it.
#[test]
fn without_the_push_it_breaks_away_at_all_of_its_friction() {
    let mut b = bench(RigConfig::free_handle(), 1);
    b.say("render on");
    b.say(&format!("{COMPENSATE} push 9.48"));
    let breaks = break_away(&mut b);
    println!("{breaks:.3?}");
    assert!(breaks[0] > 0.9 && breaks[1] > 0.6);
}

/// Noise and a wrong zero of the load cell turn the direction, never its force above the friction.
#[test]
fn a_wrong_load_cell_moves_nothing() {
    for offset in [-2.0, 0.5, 2.0] {
        for truth in [1.0, 0.92] {
            let mut rig = RigConfig::free_handle();
            (rig.load.offset, rig.load.noise) = (offset, 0.3);
            let mut b = bench(rig, 1);
            b.say("render on");
            b.say(&format!("compensate friction_p {} friction_n {} push 0.02", 1.04 / truth, 0.69 / truth));
            let rested = rests(&mut b);
            println!("offset {offset} N, {truth} of what was found: rests within {rested:.2?} counts");
            assert!(rested.iter().all(|counts| *counts < 1.0));
        }
    }
}

#[test]
fn a_share_that_drives_a_limit_cycle_is_refused_with_one_that_does_not() {
    let mut b = bench(RigConfig::free_handle(), 1);
    for (line, answer) in [
        (
            "compensate share 0.95 friction_p 1",
            "err REFUSED: share = 0.95: accepted from 0 to 0.9; above, a friction a tenth less than what was found makes the handle run by itself: a limit cycle",
        ),
        (
            "compensate friction_p 5",
            "err REFUSED: friction_p = 5: accepted from 0 to 2.844; N; three tenths of the actuator's force",
        ),
        ("compensate friction_p NaN", "err VALUE: friction_p = `NaN`: expected a finite number"),
        (
            "compensate damping 8",
            "err REFUSED: damping = 8: accepted from 0 to 6.92; N·s/m; up to the `damping` of `device`, which the stability bounds are made with",
        ),
        (
            "compensate cogging.sine_1 3",
            "err REFUSED: cogging.sine_1 = 3: accepted from -2.844 to 2.844; N; above, it is more than an error of a device",
        ),
    ] {
        assert_eq!(b.say(line), answer);
        assert_eq!(b.say("compensate"), "ok compensate off", "a rejected line changes nothing");
    }
    let unknown = b.say("compensate stribeck.force_p 1");
    assert!(
        unknown
            .starts_with("err UNKNOWN_PARAMETER: unknown parameter `stribeck.force_p`; accepted are share "),
        "{unknown}"
    );
    assert!(unknown.contains(" cogging") && !unknown.contains(" periodic_friction"), "{unknown}");
    // a steep pattern on a device without damping: the share that is accepted is accepted
    let steep = "compensate damping 6.9 cogging.sine_1 1 cogging.wavelength 0.002";
    let refused = b.say(steep);
    let most =
        refused.split("accepted up to ").nth(1).and_then(|rest| rest.split(';').next()).expect("a number");
    println!("{refused}");
    let answer = b.say(&format!("{steep} share {most}"));
    assert!(answer.starts_with("ok compensate share "), "{answer}");
}

/// A coupling is stable on the damping that is left.
#[test]
fn bounds_of_the_contact_are_those_of_the_damping_that_is_left() {
    let mut b = bench(RigConfig::free_handle(), 1);
    let most = |b: &mut Bench| {
        b.say("set b_vc 0");
        let refused = b.say("set k_vc 1e8");
        refused
            .split(" to ")
            .nth(1)
            .and_then(|rest| rest.split(';').next())
            .expect("a number")
            .parse::<f64>()
            .unwrap()
    };
    let before = most(&mut b);
    let after_line = b.say("compensate damping 6.92");
    let after = most(&mut b);
    println!("{before} N/m, {after_line}, {after} N/m");
    assert!(after_line.starts_with("ok") || after_line.contains("k_vc"), "{after_line}");
    b.say("set k_vc 100");
    assert!(b.say("compensate damping 6.92").starts_with("ok"));
    let after = most(&mut b);
    assert!((after / before - 0.1).abs() < 0.01, "a tenth of the damping, a tenth of the stiffness: {after}");
}

#[test]
fn it_is_off_while_unreferenced_and_of_another_device() {
    let rig = RigConfig { device_friction_p: 1.04, device_friction_n: 0.69, ..RigConfig::free_handle() };
    let mut b = Bench::new(rig, 1);
    for line in ["renderer impedance", "f_dynamic 0", "f_static 0", "damping 0", "k_vc 8000"] {
        b.say(&format!("set {line}"));
    }
    assert!(b.say(COMPENSATE).starts_with("ok"));
    b.say("render on");
    let largest = |b: &mut Bench| {
        b.device.hold(Holder::Force(plant::HandForce::Sine { amplitude: 1.5, frequency: 1.0, offset: 0.0 }));
        (0..2_000).fold(0.0_f32, |most, _| {
            b.run(1);
            most.max(b.device.outputs().force.abs())
        })
    };
    let most = largest(&mut b);
    // the contact of zero friction: a damper of the stuck spring
    assert!(most < 0.1, "unreferenced: {most} N");
    b.device.hold(Holder::Nobody);
    b.say("off");
    b.run(1_000);
    assert!(b.say("zero").starts_with("ok zero"));
    b.say("render on");
    assert!(largest(&mut b) > 0.9, "referenced");
    b.device.hold(Holder::Nobody);
    b.say("off");
    b.run(1_000);
    assert!(b.say("status").contains(", compensates 90 % of its friction"));
    assert!(b.say("device set mass 0.7").starts_with("ok"));
    assert_eq!(b.say("compensate"), "ok compensate off");
}

/// A change while the hand moves comes without a jump in force.
#[test]
fn switching_makes_no_jump() {
    let mut b = bench(RigConfig::free_handle(), 1);
    b.device.hold(Holder::to_and_fro(0.008, 0.5));
    b.say("render on");
    let mut jump = 0.0_f32;
    for line in [COMPENSATE, "compensate off", COMPENSATE] {
        // in the middle of a slide
        while b.device.truth().velocity < 0.02 {
            b.run(1);
        }
        let mut last = b.device.outputs().force;
        b.device.write(format!("{line}\n").as_bytes());
        for _ in 0..40 {
            b.run(1);
            let force = b.device.outputs().force;
            (jump, last) = (jump.max((force - last).abs()), force);
        }
    }
    println!("largest change in a period: {jump:.3} N");
    // a seventh of the force, which fades in 20 ms, and what the hand changes meanwhile
    assert!(jump < 0.4, "{jump}");
}

#[test]
fn it_rests_at_every_rate() {
    for rate in haptics::RATES {
        let mut b = bench(RigConfig::free_handle(), 2);
        assert!(b.say(&format!("rate {rate}")).starts_with("ok rate"));
        b.say("render on");
        let answer = b.say(COMPENSATE);
        assert!(answer.starts_with("ok"), "{answer}");
        let (slides, rested) = (felt(&mut b), rests(&mut b));
        println!("{rate} Hz: felt {slides:.3?}, rests within {rested:.2?} counts");
        assert!(
            slides.iter().all(|felt| (0.05..0.15).contains(felt))
                && rested.iter().all(|counts| *counts < 1.0)
        );
    }
}
