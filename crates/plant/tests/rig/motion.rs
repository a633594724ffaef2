//! The rig's mechanics against closed forms.

use friction::{Custom, Motion};
use plant::{Coupling, Hand, HandForce, HandImpedance, NoHand, Rig, RigConfig, Target, Zoh};

/// Coulomb friction of `level` N as a stopping force.
fn dry(level: f64) -> Custom<impl Fn(&Motion<f64>) -> f64 + Clone> {
    Custom(move |m: &Motion<f64>| (m.applied + m.mass * m.velocity / m.dt).clamp(-level, level))
}

/// No friction at all.
fn slick() -> Custom<impl Fn(&Motion<f64>) -> f64 + Clone> {
    Custom(|_: &Motion<f64>| 0.0)
}

/// A device without friction, stops, limits or delay.
fn bare() -> RigConfig {
    RigConfig {
        stroke: None,
        force_max: None,
        actuation_delay: 0,
        load: plant::Sensor { noise: 0.0, gain: 1.0, offset: 0.0 },
        accel: plant::Sensor { noise: 0.0, gain: 1.0, offset: 0.0 },
        ..RigConfig::free_handle()
    }
}

#[test]
fn zero_order_hold_is_exact() {
    // against the closed form of [thesis, eq. 4.15] over one second, 20 000 steps, force changing every millisecond
    for (mass, damping) in
        [(0.692, 6.92), (1.0, 10.0), (0.692, 1e-3), (0.692, 1e-9), (0.692, 0.0), (0.1, 400.0)]
    {
        let config = RigConfig { device_mass: mass, device_damping: damping, ..bare() };
        let mut rig = Rig::new(config, slick(), 1).unwrap();
        let (mut x, mut v) = (0.0f64, 0.0f64);
        let mut worst = 0.0f64;
        for k in 0..1000 {
            let force = if (k / 100) % 2 == 0 { 2.0 } else { -2.0 };
            rig.tick(force, &mut NoHand);
            let t = 1e-3;
            // damping so small that the closed form cancels in f64 is compared with its limit instead
            if damping * t / mass > 1e-6 {
                let tau = mass / damping;
                let (decay, gone) = ((-t / tau).exp(), -(-t / tau).exp_m1());
                let settled = force / damping;
                x += settled * (t - tau * gone) + v * tau * gone;
                v = settled * gone + v * decay;
            } else {
                x += v * t + 0.5 * force / mass * t * t;
                v += force / mass * t;
            }
            let truth = rig.truth();
            worst = worst.max((truth.position - x).abs()).max((truth.velocity - v).abs());
        }
        println!("m {mass} kg, b {damping} N·s/m: worst difference {worst:.2e} m, m/s");
        let limit = if damping == 1e-9 { 1e-8 } else { 1e-12 };
        assert!(worst < limit, "m {mass}, b {damping}: {worst:e}");
    }
}

#[test]
fn coefficients_have_the_undamped_limit() {
    let limit = Zoh::new(0.692, 0.0, 5e-5);
    assert_eq!(limit.decay, 1.0);
    assert_eq!(limit.velocity_per_force, 5e-5 / 0.692);
    assert_eq!(limit.displacement_per_velocity, 5e-5);
    assert!((limit.displacement_per_force / (0.5 * 5e-5 * 5e-5 / 0.692) - 1.0).abs() < 1e-15);
    // continuous across the switch from series to closed form, at y = 0.25
    let below = Zoh::new(1.0, 0.25 * (1.0 - 1e-12), 1.0);
    let above = Zoh::new(1.0, 0.25, 1.0);
    assert!((below.displacement_per_force - above.displacement_per_force).abs() < 1e-12);
    assert!((below.displacement_per_velocity - above.displacement_per_velocity).abs() < 1e-12);
    // a stopping force stops exactly, damped or not
    for damping in [0.0, 6.92, 500.0] {
        let zoh = Zoh::new(0.692, damping, 5e-5);
        let (_, v) = zoh.advance(0.1, -(zoh.stopping_mass / zoh.step - damping) * 0.1);
        assert!(v.abs() < 1e-16, "b {damping}: {v:e}");
    }
}

#[test]
fn below_break_away_nothing_creeps_for_ten_seconds() {
    // 3.0 N on device friction 1.04 N and a block held by 2 N; the sgn(v) closure is held by the rig itself
    let naive = Custom(|m: &Motion<f64>| 2.0 * friction::Scalar::sgn(m.velocity));
    fn drift<L: friction::FrictionLaw<f64>>(law: L) -> (f64, f64) {
        let mut rig = Rig::new(RigConfig::default(), law, 3).unwrap();
        let mut worst = (0.0f64, 0.0f64);
        for k in 0..10_000 {
            // also wiggle the load: a creeping law walks under it
            rig.tick(if k % 7 < 3 { 3.0 } else { -0.5 }, &mut NoHand);
            let truth = rig.truth();
            worst = (worst.0.max(truth.position.abs()), worst.1.max(truth.velocity.abs()));
            assert!(truth.stuck);
        }
        worst
    }
    let (a, b) = (drift(dry(2.0)), drift(naive));
    println!("drift in 10 s: stopping law {a:?}, sgn(v) closure {b:?}");
    assert_eq!((a, b), ((0.0, 0.0), (0.0, 0.0)));
}

#[test]
fn sliding_block_comes_to_rest_and_stays() {
    // release at speed, no hand: from the first rest on, position must not change by a bit
    for law_is_naive in [false, true] {
        let law = Custom(move |m: &Motion<f64>| {
            if law_is_naive {
                2.0 * friction::Scalar::sgn(m.velocity)
            } else {
                (m.applied + m.mass * m.velocity / m.dt).clamp(-2.0, 2.0)
            }
        });
        let mut rig = Rig::new(RigConfig::default(), law, 3).unwrap();
        for _ in 0..40 {
            rig.tick(8.0, &mut NoHand);
        }
        let mut rest = None;
        for _ in 0..2000 {
            rig.tick(0.0, &mut NoHand);
            let truth = rig.truth();
            match rest {
                None if truth.velocity == 0.0 => rest = Some(truth.position),
                None => {}
                Some(position) => assert_eq!((truth.position, truth.velocity), (position, 0.0)),
            }
        }
        println!("rest at {:.6} mm", rest.unwrap() * 1e3);
    }
}

#[test]
fn holding_has_the_levels_of_table_3_1() {
    let break_away = |direction: f64| {
        let mut rig = Rig::new(RigConfig { block_mass: 0.0, ..RigConfig::default() }, slick(), 1).unwrap();
        let mut force = 0.0;
        while rig.truth().velocity == 0.0 {
            force += 1e-3 * direction;
            rig.tick(force, &mut NoHand);
        }
        force - 1e-3 * direction
    };
    let (forward, reverse) = (break_away(1.0), break_away(-1.0));
    println!("device breaks away at {forward:.3} N and {reverse:.3} N");
    assert!((forward - 1.04).abs() < 2.5e-3 && (reverse + 0.69).abs() < 2.5e-3);
}

#[test]
fn terminal_velocity() {
    let config = RigConfig { device_damping: 50.0, block_mass: 0.419, ..bare() };
    let mut rig = Rig::new(config, dry(2.0), 1).unwrap();
    for _ in 0..2000 {
        rig.tick(7.0, &mut NoHand);
    }
    let expected = (7.0 - 2.0) / 50.0;
    println!("terminal velocity {} m/s, closed form {expected}", rig.truth().velocity);
    assert!((rig.truth().velocity - expected).abs() < 1e-12);
    assert!((rig.truth().force_at_load_cell - 2.0).abs() < 1e-9);
}

#[test]
fn stopping_distance() {
    // m v' = −C − b v: x = (m/b)(v0 − (C/b)·ln(1 + b·v0/C)); without damping m·v0²/2C
    for damping in [0.0, 6.92] {
        let config = RigConfig { device_damping: damping, block_mass: 0.419, ..bare() };
        let mass = 0.692 + 0.419;
        let level = 1.7;
        let mut rig = Rig::new(config, dry(level), 1).unwrap();
        for _ in 0..50 {
            rig.tick(6.0, &mut NoHand);
        }
        let (x0, v0) = (rig.truth().position, rig.truth().velocity);
        while rig.truth().velocity != 0.0 {
            rig.tick(0.0, &mut NoHand);
        }
        let distance = rig.truth().position - x0;
        let closed = if damping == 0.0 {
            mass * v0 * v0 / (2.0 * level)
        } else {
            mass / damping * (v0 - level / damping * (damping * v0 / level).ln_1p())
        };
        // the last partial step has a smaller constant force: an error of at most v·h/2
        println!("b {damping}: stops in {distance:.9} m, closed form {closed:.9} m");
        assert!((distance - closed).abs() < 2e-8, "{distance} {closed}");
        assert_eq!(rig.truth().velocity, 0.0);
    }
}

#[test]
fn work_equals_kinetic_energy_plus_friction_loss() {
    // no viscous damping, so friction is the only loss; 10 s of pushes with stick and slip
    let config = RigConfig { device_damping: 0.0, actuation_delay: 1, block_mass: 0.419, ..bare() };
    let config = RigConfig { device_friction_p: 1.04, device_friction_n: 0.69, ..config };
    let mut rig = Rig::new(config, dry(1.7), 1).unwrap();
    let mut hand = HandForce::Sine { amplitude: 3.0, frequency: 2.3, offset: 0.1 };
    let (mut worst, mut previous, mut moved) = (0.0f64, 0.0, 0.0);
    for k in 0..10_000 {
        let command = 2.5 * (0.011 * f64::from(k)).sin();
        rig.tick(command, &mut hand);
        let t = rig.truth();
        let kinetic = 0.5 * (0.692 + 0.419) * t.velocity * t.velocity;
        worst = worst.max((t.actuator_work + t.hand_work - t.friction_work - kinetic).abs());
        assert!(t.friction_work >= previous, "friction gave energy back at {} s", t.time);
        previous = t.friction_work;
        moved = t.actuator_work + t.hand_work;
    }
    println!("{moved:.3} J of work, balance within {worst:.2e} J");
    assert!(moved > 1.0 && worst < 1e-9 * moved);
}

#[test]
fn one_period_of_actuation_delay_and_no_more() {
    for delay in 0..=3u32 {
        let config = RigConfig { actuation_delay: delay, device_damping: 0.0, ..bare() };
        let mut rig = Rig::new(config, slick(), 1).unwrap();
        let mut moved_at = None;
        for k in 0..8 {
            rig.tick(if k == 0 { 1.0 } else { 0.0 }, &mut NoHand);
            if rig.truth().velocity != 0.0 && moved_at.is_none() {
                moved_at = Some(k);
            }
        }
        println!("delay {delay}: pulse in call 0 first moves the handle in call {moved_at:?}");
        assert_eq!(moved_at, Some(delay as usize));
        // the pulse acted for exactly one period
        assert!((rig.truth().velocity - 1e-3 / 0.692).abs() < 1e-15);
    }
    assert_eq!(RigConfig::default().actuation_delay, 1);
}

#[test]
fn actuator_saturates() {
    let mut rig = Rig::new(RigConfig { stroke: None, ..RigConfig::free_handle() }, slick(), 1).unwrap();
    for (command, expected) in [(100.0, 9.48), (-20.0, -9.48), (3.0, 3.0)] {
        rig.tick(command, &mut NoHand);
        rig.tick(command, &mut NoHand);
        assert_eq!(rig.truth().actuator_force, expected);
    }
}

#[test]
fn impedance_hand_settles_where_springs_balance() {
    let config = RigConfig { device_damping: 1.0, ..bare() };
    let mut rig = Rig::new(config, slick(), 1).unwrap();
    let mut hand = HandImpedance::relaxed(Target::Hold { position: 0.004 });
    for _ in 0..5000 {
        rig.tick(0.8, &mut hand);
    }
    let expected = 0.004 + 0.8 / 400.0;
    let truth = rig.truth();
    println!("rest at {} m, closed form {expected}; hand {} N", truth.position, truth.hand_force);
    assert!((truth.position - expected).abs() < 1e-9 && (truth.hand_force + 0.8).abs() < 1e-6);
}

#[test]
fn impedance_hand_swings_at_its_frequency() {
    // m = device + hand; no damping: the amplitude must neither grow nor shrink
    let config = RigConfig { device_damping: 0.0, ..bare() };
    let mut hand = HandImpedance {
        mass: 0.108,
        stiffness: 2000.0,
        damping: 0.0,
        target: Target::Hold { position: 0.005 },
    };
    let mut rig = Rig::new(config, slick(), 1).unwrap();
    let omega = (2000.0f64 / 0.8).sqrt();
    let (mut worst, mut crossings, mut last) = (0.0f64, Vec::new(), -0.005);
    for k in 1..=20_000 {
        rig.tick(0.0, &mut hand);
        let t = rig.truth();
        let offset = t.position - 0.005;
        let amplitude = (offset * offset + (t.velocity / omega).powi(2)).sqrt();
        worst = worst.max((amplitude - 0.005).abs());
        if last < 0.0 && offset >= 0.0 {
            crossings.push(f64::from(k) - offset / (offset - last));
        }
        last = offset;
    }
    let n = crossings.len() - 1;
    let period = (crossings[n] - crossings[0]) * 1e-3 / n as f64;
    let frequency = 1.0 / period;
    let expected = omega / std::f64::consts::TAU;
    println!(
        "{frequency:.5} Hz, closed form {expected:.5}; amplitude within {worst:.2e} m of 5 mm over 20 s"
    );
    assert!((frequency / expected - 1.0).abs() < 1e-4);
    assert!(worst < 1e-6);
}

#[test]
fn compliant_coupling_has_its_natural_frequency() {
    for stiffness in [2e4, 4e5] {
        let config = RigConfig {
            device_damping: 0.0,
            block_mass: 0.419,
            coupling: Coupling::Compliant { stiffness, damping: 0.0 },
            ..bare()
        };
        let mut rig = Rig::new(config, slick(), 1).unwrap();
        let omega = (stiffness * (1.0 / 0.692 + 1.0 / 0.419f64)).sqrt();
        rig.tick(5.0, &mut NoHand);
        let relative = |t: plant::Truth| t.position - t.block_position;
        let amplitude = |t: plant::Truth| {
            (relative(t).powi(2) + ((t.velocity - t.block_velocity) / omega).powi(2)).sqrt()
        };
        rig.tick(0.0, &mut NoHand);
        let first = amplitude(rig.truth());
        let (mut last, mut crossings) = (relative(rig.truth()), Vec::new());
        for k in 1..=5000 {
            rig.tick(0.0, &mut NoHand);
            let now = relative(rig.truth());
            if last < 0.0 && now >= 0.0 {
                crossings.push(f64::from(k) - now / (now - last));
            }
            last = now;
        }
        let n = crossings.len() - 1;
        let frequency = n as f64 / ((crossings[n] - crossings[0]) * 1e-3);
        let expected = omega / std::f64::consts::TAU;
        let kept = amplitude(rig.truth()) / first;
        println!(
            "k {stiffness} N/m: {frequency:.4} Hz, closed form {expected:.4}; amplitude × {kept:.6} in 5 s"
        );
        assert!((frequency / expected - 1.0).abs() < 2e-3 && (kept - 1.0).abs() < 2e-2);
        // momentum of the pair is what the push gave
        let t = rig.truth();
        assert!((0.692 * t.velocity + 0.419 * t.block_velocity - 5e-3).abs() < 1e-12);
        assert!((t.force_at_load_cell - stiffness * relative(t)).abs() < 1e-9);
    }
}

#[test]
fn compliant_block_sticks_while_the_handle_stretches_the_coupling() {
    let config = RigConfig {
        block_mass: 0.419,
        coupling: Coupling::Compliant { stiffness: 2e4, damping: 20.0 },
        ..bare()
    };
    let mut rig = Rig::new(config, dry(2.0), 1).unwrap();
    for _ in 0..3000 {
        rig.tick(0.9, &mut NoHand);
    }
    let t = rig.truth();
    println!(
        "handle {:.3e} m, block {:.1e} m, load cell {} N",
        t.position, t.block_position, t.force_at_load_cell
    );
    assert_eq!((t.block_position, t.block_velocity), (0.0, 0.0));
    assert!(t.stuck && (t.position - 0.9 / 2e4).abs() < 1e-9 && (t.force_at_load_cell - 0.9).abs() < 1e-6);
}

#[test]
fn hard_stops_contain_the_handle() {
    let mut rig = Rig::new(RigConfig::free_handle(), slick(), 1).unwrap();
    let (mut low, mut high) = (0.0f64, 0.0f64);
    for k in 0..4000 {
        // full force to and fro, 0.5 s each way
        rig.tick(if (k / 500) % 2 == 0 { 9.48 } else { -9.48 }, &mut NoHand);
        let t = rig.truth();
        (low, high) = (low.min(t.position), high.max(t.position));
        // a stop pushes inwards only
        assert!(t.stop_force * t.position <= 0.0);
    }
    println!("range {:.3} mm to {:.3} mm", low * 1e3, high * 1e3);
    // kinetic energy at the stop, all of it in the spring: the deepest a bounce can go
    let fastest = (2.0 * 9.48 * 0.032 / 0.692f64).sqrt();
    let deepest = fastest * (0.692f64 / 5e5).sqrt() + 2.0 * 9.48 / 5e5;
    assert!(high > 0.016 && low < -0.016);
    assert!(high < 0.016 + deepest && low > -0.016 - deepest);
    // leaning on the stop: static depth F/k
    for _ in 0..2000 {
        rig.tick(9.48, &mut NoHand);
    }
    assert!((rig.truth().position - (0.016 + 9.48 / 5e5)).abs() < 1e-7, "{}", rig.truth().position);
}

#[test]
fn stiff_viscous_law_stops_and_never_drives() {
    // b·h/m = 45: an explicit integrator would be unstable
    let thick = Custom(|m: &Motion<f64>| 1e6 * m.velocity);
    let mut rig = Rig::new(RigConfig { block_mass: 0.419, ..bare() }, thick, 1).unwrap();
    for k in 0..1000 {
        rig.tick(if k < 500 { 5.0 } else { 0.0 }, &mut NoHand);
        assert!(rig.truth().velocity.abs() < 1e-3, "{}", rig.truth().velocity);
    }
}

#[test]
fn scripted_hands_follow_their_script() {
    let mut push = HandForce::PushRelease { force: 2.0, from: 0.1, until: 0.2 };
    assert_eq!([0.05, 0.1, 0.15, 0.2].map(|t| push.force(t, 0.0, 0.0)), [0.0, 2.0, 2.0, 0.0]);
    let mut ramp = HandForce::Ramp { rate: -3.0, from: 1.0, limit: 4.0 };
    assert_eq!([0.5, 2.0, 9.0].map(|t| ramp.force(t, 0.0, 0.0)), [0.0, -3.0, -4.0]);
    let mut steps = HandForce::Steps(vec![(0.1, 1.0), (0.2, -1.0)]);
    assert_eq!([0.0, 0.1, 0.19, 5.0].map(|t| steps.force(t, 0.0, 0.0)), [0.0, 1.0, 1.0, -1.0]);
    assert_eq!(HandForce::Steps(vec![]).force(1.0, 0.0, 0.0), 0.0);
    let mut sine = HandForce::Sine { amplitude: 2.0, frequency: 1.0, offset: 0.5 };
    assert!((sine.force(0.25, 0.0, 0.0) - 2.5).abs() < 1e-12);
    // targets: velocity is the derivative of position
    let reach = Target::Reach { from: -0.01, to: 0.01, at: 0.2, duration: 0.5 };
    for target in [
        reach,
        Target::Sine { centre: 0.0, amplitude: 0.01, frequency: 2.0 },
        Target::Ramp { start: 0.0, velocity: 0.1 },
    ] {
        for k in 1..100 {
            let t = f64::from(k) * 0.01;
            let slope = (target.at(t + 1e-6).0 - target.at(t - 1e-6).0) / 2e-6;
            assert!((slope - target.at(t).1).abs() < 1e-6, "{target:?} at {t}");
        }
    }
    assert_eq!(reach.at(5.0), (0.01, 0.0));
    // a closure is a hand
    let mut rig = Rig::new(bare(), slick(), 1).unwrap();
    rig.tick(0.0, &mut |_t: f64, _x: f64, _v: f64| 1.0);
    assert_eq!(rig.truth().hand_force, 1.0);
}
