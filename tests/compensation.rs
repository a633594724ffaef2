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

#[test]
fn try_it() {
    let mut b = bench(RigConfig::free_handle(), 1);
    println!("{}", b.say("render on"));
    println!("before {:?}", felt(&mut b));
    println!("{}", b.say(COMPENSATE));
    println!("{}", b.say("status"));
    println!("after {:?} {:?}", felt(&mut b), b.device.outputs());
}
