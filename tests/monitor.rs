//! The slow checks on the virtual device: what they find, when, and what they leave alone.
#![cfg(not(target_os = "none"))]

use haptics::{FaultKind, Limits, ModeId};
use plant::{HandForce, RigConfig};
use tribos_firmware::board::simulated::Holder;
use tribos_firmware::{VirtualConfig, VirtualDevice};

struct Bench {
    device: VirtualDevice,
}

impl Bench {
    fn new(rig: RigConfig, seed: u64) -> Self {
        let device = VirtualDevice::new(&VirtualConfig { seed, rig }).expect("a rig");
        let mut bench = Self { device };
        bench.run(50);
        bench
    }

    fn run(&mut self, ms: u32) {
        (0..ms).for_each(|_| self.device.tick());
    }

    /// One command; what is said until it is answered.
    fn say(&mut self, command: &str) -> String {
        let mut said = Vec::new();
        self.device.read(&mut said);
        said.clear();
        self.device.write(format!("{command}\n").as_bytes());
        for _ in 0..3_000 {
            self.device.tick();
            self.device.read(&mut said);
            if self.device.is_quiet() && !said.is_empty() {
                break;
            }
        }
        String::from_utf8_lossy(&said).trim_end().to_owned()
    }

    /// Runs until a fault, at most this long. Its kind, and the time, ms.
    fn until_fault(&mut self, ms: u32) -> (Option<FaultKind>, u32) {
        for k in 0..ms {
            self.device.tick();
            if let Some(kind) = self.device.outputs().fault {
                return (Some(kind), k);
            }
        }
        (None, ms)
    }
}

fn pushed(newton: f64) -> Holder {
    Holder::Force(HandForce::Steps(vec![(0.0, newton)]))
}

/// Pressed slowly, so that the block sticks.
fn pressed(newton: f64) -> Holder {
    Holder::Force(HandForce::Ramp { rate: 3.0, from: 0.0, limit: newton })
}

#[test]
fn a_broken_command_wire_is_found_within_two_millimetres() {
    println!("{:<10} {:<14} {:>9} {:>10} {:>8}", "preset", "hand", "after", "moved", "speed");
    for preset in ["brass", "teflon", "rubber", "viscous"] {
        for hand in [-3.0, 0.0, 3.0] {
            let mut bench = Bench::new(RigConfig::free_handle(), 3);
            bench.say("zero");
            bench.say(&format!("preset use {preset}"));
            bench.say("render on");
            bench.device.hold(pushed(hand));
            bench.run(40);
            let from = bench.device.truth().position;
            bench.say("sim wire command dead");
            let (kind, ms) = bench.until_fault(200);
            let truth = bench.device.truth();
            let moved = (truth.position - from).abs();
            println!(
                "{preset:<10} {hand:>6} N {ms:>13} ms {:>7.2} mm {:>5.2} m/s",
                1e3 * moved,
                truth.velocity.abs()
            );
            assert_eq!(kind, Some(FaultKind::ForceContradicted));
            assert!(moved < 2e-3 && truth.velocity.abs() < 0.3, "{preset}, {hand} N");
        }
    }
}

#[test]
fn an_unreferenced_device_finds_a_broken_command_wire_in_motion() {
    let mut bench = Bench::new(RigConfig::free_handle(), 4);
    bench.say("render on");
    bench.say("sim wire command dead");
    let (kind, ms) = bench.until_fault(200);
    println!("unreferenced: after {ms} ms at {:.2} m/s", bench.device.truth().velocity);
    assert_eq!(kind, Some(FaultKind::ForceContradicted));
    assert!(ms < 45);
}

#[test]
fn a_hand_against_an_unknown_stop_contradicts_nothing() {
    // the stop takes 8 N that no sensor sees
    let mut bench = Bench::new(RigConfig { start_position: 0.0155, ..RigConfig::free_handle() }, 5);
    bench.say("render on");
    for newton in [8.0, 0.0, 8.0, -2.0, 8.0] {
        bench.device.hold(pushed(newton));
        assert_eq!(bench.until_fault(1_500), (None, 1_500), "{newton} N");
    }
}

#[test]
fn heat_follows_its_equation() {
    // h' = (F²/F₀² − h)/τ from 0: h = 1 at τ·ln(q/(q − 1)), q = F²/F₀²
    let limits = Limits::default();
    for (newton, tau) in [(9.0_f64, 10.0_f64), (8.5, 20.0)] {
        let mut bench = Bench::new(RigConfig::free_handle(), 6);
        bench.say("zero");
        bench.say("preset use rubber");
        bench.say("set f_static 9.4");
        bench.say("limit heating 3600");
        bench.say("render on");
        bench.device.hold(pressed(newton));
        assert_eq!(bench.until_fault(4_000).0, None);
        assert_eq!(bench.say(&format!("limit heating {tau}")), format!("ok limit heating {tau} s"));
        let (kind, ms) = bench.until_fault(200_000);
        let q = (newton / f64::from(limits.continuous_force)).powi(2);
        let expected = 1e3 * tau * (q / (q - 1.0)).ln();
        println!("{newton} N, {tau} s: motor_hot after {ms} ms, {expected:.0} by the equation");
        assert_eq!(kind, Some(FaultKind::MotorHot));
        assert!((f64::from(ms) / expected - 1.0).abs() < 0.03);
        // still hot: the force comes back only once it has cooled
        bench.device.hold(Holder::Nobody);
        bench.run(300);
        bench.say("clear");
        assert_eq!(bench.device.mode(), ModeId::Idle);
    }
    // the motor holds this for ever
    let mut bench = Bench::new(RigConfig::free_handle(), 6);
    bench.say("zero");
    bench.say("preset use rubber");
    bench.say("set f_static 9.4");
    bench.say("limit heating 5");
    bench.say("render on");
    bench.device.hold(pressed(7.5));
    assert_eq!(bench.until_fault(60_000).0, None);
}

#[test]
fn a_refused_limit_changes_nothing() {
    let mut bench = Bench::new(RigConfig::free_handle(), 7);
    let before = bench.say("limit");
    for (typed, refused) in [
        ("limit heating 0", "err REFUSED: heating = 0: accepted from 1 to 3600; s"),
        ("limit continuous_force 12", "err REFUSED: continuous_force = 12: accepted from 0.474 to 9.48; N"),
        (
            "limit unexplained_force 0.1",
            "err REFUSED: unexplained_force = 0.1: accepted from 0.948 to 9.48; N",
        ),
        (
            "limit force 3",
            "err UNKNOWN_PARAMETER: `force`: expected one of unexplained_force, continuous_force, heating",
        ),
        ("limit heating NaN", "err VALUE: VALUE = `NaN`"),
    ] {
        let answer = bench.say(typed);
        assert!(answer.starts_with(refused), "{typed}: {answer}");
    }
    assert_eq!(bench.say("limit"), before);
}

#[test]
fn a_host_that_leaves_while_rendering_is_a_fault_only_if_asked() {
    let mut bench = Bench::new(RigConfig::free_handle(), 8);
    bench.say("zero");
    bench.say("watch 1");
    bench.say("render on");
    assert_eq!(bench.until_fault(3_000).0, None);
    assert_eq!(
        bench.say("watch 1 render"),
        "ok watch 1 s: force off after this silence of the host, also while rendering"
    );
    // a talking host
    for _ in 0..10 {
        assert_eq!(bench.until_fault(500).0, None);
        bench.device.write(b"\n");
    }
    // withdrawn while rendering
    bench.say("watch 1");
    assert_eq!(bench.until_fault(3_000).0, None);
    bench.say("render off");
    bench.say("watch 1 render");
    bench.say("render on");
    let (kind, ms) = bench.until_fault(2_000);
    assert_eq!(kind, Some(FaultKind::HostSilent));
    assert!((900..1_100).contains(&ms), "{ms}");
}
