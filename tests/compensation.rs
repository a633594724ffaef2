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
    for line in ["renderer impedance", "f_dynamic 0", "f_static 0", "damping 0", "dv 0.0001", "k_vc 8000", "b_vc 15"] {
        let _ = bench.say(&format!("set {line}"));
    }
    for line in ["f_static 0", "f_dynamic 0", "f_static 0"] {
        let answer = bench.say(&format!("set {line}"));
        assert!(answer.starts_with("ok"), "{answer}");
    }
    bench
}

const COMPENSATE: &str = "compensate friction_p 1.04 friction_n 0.69 damping 6.9";

/// Forces of a true hand while the handle slides, N, without mass and damping that are left: means of both directions; and
/// the push at which the handle breaks away.
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
        bench.device.hold(Holder::Hand(HandImpedance { stiffness: 1_500.0, damping: 60.0, ..HandImpedance::relaxed(Target::Hold { position: 0.0 }) }));
        bench.run(1_500);
        bench.device.hold(Holder::Nobody);
        bench.run(500);
        let begin = bench.device.truth();
        bench.device.hold(Holder::Force(plant::HandForce::Ramp { rate: sign * 0.5, from: begin.time, limit: 3.0 }));
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
    let hand = |k: f64, b: f64, position: f64| Holder::Hand(HandImpedance { stiffness: k, damping: b, ..HandImpedance::relaxed(Target::Hold { position }) });
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
fn try_it() {
    for offset in [0.0, 0.5] {
    for (share, speed, push) in [(0.9, 0.002, 9.48), (0.9, 0.002, 0.1), (0.9, 0.002, 0.05), (0.9, 0.002, 0.2), (0.9, 0.0005, 0.1), (0.9, 0.005, 0.1), (0.9, 0.02, 9.48), (0.9, 0.02, 0.1)] {
        for truth in [1.0, 0.95, 0.85] {
            let mut rig = RigConfig::free_handle();
            rig.load.offset = offset;
            let mut b = bench(rig, 1);
            b.say("render on");
            let (p, n) = (1.04 / truth, 0.69 / truth);
            let a = b.say(&format!("compensate share {share} friction_p {p} friction_n {n} damping 6.9 speed {speed} push {push}"));
            assert!(a.starts_with("ok"), "{a}");
            let (f, a, r) = (felt(&mut b), break_away(&mut b), rests(&mut b));
            println!("offset {offset} share {share} speed {speed} push {push}, true/found {truth}: felt {:.3} {:.3} N, breaks away {:.3} {:.3} N, rests {:.1} {:.1} {:.1} counts", f[0], f[1], a[0], a[1], r[0], r[1], r[2]);
        }
    }
    }
}
