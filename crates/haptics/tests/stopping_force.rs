//! The stopping-force renderer: breaks away at its level up to rounding, comes to rest and stays there without a dead band,
//! and adds no energy. Positions are exact here; tests/renderer.rs has the encoder.

use haptics::renderer::{Contact, Handle};
use haptics::{Config, Device, LawKind, RendererKind, Settings, bounds};
use proptest::test_runner::{Config as Cases, RngAlgorithm, TestRng, TestRunner};
use proptest::{prop_assert, strategy::Strategy};

const T: f64 = 1e-3;

fn built(settings: &Settings) -> Config {
    settings.build(&Device { delay: 20e-6, ..Device::default() }).expect("within the bounds")
}

fn base() -> Settings {
    Settings {
        renderer: RendererKind::StoppingForce,
        // a negligible dead band: it must not matter
        dv: 1e-6,
        ..Settings::rubber()
    }
}

#[test]
fn breaks_away_at_the_static_level_for_any_dv() {
    for dv in [1e-6, 0.02] {
        for (sign, level) in [(1.0_f32, 3.8513_f32), (-1.0, 2.9099)] {
            let config = built(&Settings { dv, ..base() });
            let mut handle = Handle::default();
            let mut contact = Contact::new(&config, &handle);
            let (mut before, mut steps) = (0.0_f32, 0);
            let rendered = loop {
                // 0.1 µm a step, at rest: 0.8 mN
                handle.position += sign * 1e-7;
                let rendered = contact.step(&config, &handle);
                if !rendered.stuck {
                    break rendered;
                }
                assert_eq!((rendered.block_position, rendered.block_velocity), (0.0, 0.0));
                before = rendered.force;
                steps += 1;
            };
            println!(
                "dv {dv}: held {:.5} N, broke at the next 0.8 mN (static {level}); then {:.4} N of friction",
                before.abs(),
                rendered.friction
            );
            assert!(before.abs() <= level * (1.0 + 1e-5) && before.abs() > level - 1e-3);
            assert!(steps > 3_000);
            assert!(rendered.friction.abs() < level, "falls to the dynamic level at once");
        }
    }
}

/// A block thrown by the handle, which then stands still: any stable coupling and either kind of law.
fn throws() -> impl Strategy<Value = (Settings, f32)> {
    let log = |low: f64, high: f64| (low.ln()..high.ln()).prop_map(f64::exp);
    let mass = log(2e-3, 5.0);
    let levels = (0.0..5.0_f64, 0.0..4.0_f64, 0.0..20.0_f64);
    (mass, 0.0..0.98_f64, 0.0..0.98_f64, levels, -0.4..0.4_f64, proptest::bool::ANY).prop_map(
        |(mass, stiff, damped, (level, more, viscous), speed, karnopp)| {
            let device = Device::default();
            // shares of the block's bounds, within those of the handle
            let b_vc = (damped * bounds::damping_singular(mass, 0.0, T)).min(100.0);
            let k_vc = stiff * bounds::stiffness_singular(mass, b_vc + viscous, T);
            let handle = bounds::stiffness_max_delayed(
                f64::from(device.mass),
                f64::from(device.damping),
                T,
                b_vc,
                20e-6,
            );
            let law = if karnopp { LawKind::Karnopp } else { LawKind::Coulomb };
            let settings = Settings {
                law,
                mass: mass as f32,
                b_vc: b_vc as f32,
                k_vc: k_vc.min(0.99 * handle) as f32,
                f_dynamic_p: level as f32,
                f_dynamic_n: (0.7 * level) as f32,
                f_static_p: (level + more) as f32,
                f_static_n: (level + more) as f32,
                damping_p: viscous as f32,
                damping_n: viscous as f32,
                ..base()
            };
            (settings, speed as f32)
        },
    )
}

#[test]
fn a_thrown_block_rests_and_energy_only_falls() {
    let mut runner = TestRunner::new_with_rng(
        Cases { cases: 3_000, failure_persistence: None, ..Cases::default() },
        TestRng::deterministic_rng(RngAlgorithm::ChaCha),
    );
    let (tried, slowest, gained) =
        (std::cell::Cell::new(0), std::cell::Cell::new(0), std::cell::Cell::new(0.0_f64));
    let done = runner.run(&throws(), |(settings, speed)| {
        let device = Device { delay: 20e-6, ..Device::default() };
        if settings.validate(&device).is_err() || settings.f_dynamic_n < 0.02 {
            return Ok(());
        }
        tried.set(tried.get() + 1);
        let config = built(&settings);
        let moving = Handle { velocity: speed, ..Handle::default() };
        let mut contact = Contact::new(&config, &moving);
        let wide = |x: f32| f64::from(x);
        let (mut energy, mut rested) = (f64::INFINITY, None);
        let mut last = 0.0_f32;
        let start = 0.5 * wide(settings.mass) * wide(speed) * wide(speed);
        for k in 0..40_000 {
            let rendered = contact.step(&config, &Handle::default());
            let (p, w) = (wide(rendered.block_position), wide(rendered.block_velocity));
            let now = 0.5 * wide(settings.mass) * w * w + 0.5 * wide(settings.k_vc) * p * p;
            // within the limit of the actuator the spring in the hand is this one
            if rendered.force.abs() < 9.0 && last * rendered.block_velocity >= 0.0 {
                gained.set(gained.get().max((now - energy) / start));
            }
            (energy, last) = (now, rendered.block_velocity);
            match rested {
                None if rendered.stuck => rested = Some((k, rendered.block_position)),
                Some((_, at)) if k < 20_000 || rendered.stuck => {
                    if !rendered.stuck {
                        rested = None; // reversed: static friction does not hold the spring yet
                    } else {
                        prop_assert!(rendered.block_position == at && rendered.block_velocity == 0.0);
                    }
                }
                Some(_) => prop_assert!(false, "moves again after 20 s"),
                None => {}
            }
            if rested.is_some_and(|(since, _)| k > since + 2_000) {
                break;
            }
        }
        prop_assert!(rested.is_some(), "{settings:?} thrown at {speed}");
        slowest.set(slowest.get().max(rested.map_or(0, |r| r.0)));
        Ok(())
    });
    println!(
        "{} blocks thrown: all at rest, not one bit of motion after; the slowest took {} periods; largest gain of energy in a period without a reversal {:.1e} of what it was thrown with",
        tried.get(),
        slowest.get(),
        gained.get()
    );
    done.expect("comes to rest");
    assert!(tried.get() > 1_000);
    // change of the spring while the block stops within one period, at 98 % of the stability bound
    assert!(gained.get() < 1e-2);
}

#[test]
fn a_closed_path_only_takes_work() {
    // back and forth with a smaller motion added, so that the block reverses in every way
    for (rate, mass, k_vc, b_vc) in [
        (9.0, 0.4_f32, 8_000.0_f32, 15.0_f32),
        (60.0, 0.05, 20_000.0, 5.0),
        (200.0, 1.0, 7_500.0, 0.0),
        (31.0, 0.01, 2_000.0, 3.0),
    ] {
        let settings = Settings { mass, k_vc, b_vc, ..base() };
        let (config, device) = (built(&settings), Device::default());
        let x = |t: f64| 4e-3 * (rate * t).sin() + 1e-3 * (3.0 * rate * t).sin();
        let v = |t: f64| rate * (4e-3 * (rate * t).cos() + 3e-3 * (3.0 * rate * t).cos());
        let at = |t: f64| Handle { position: x(t) as f32, velocity: v(t) as f32, ..Handle::default() };
        let mut contact = Contact::new(&config, &at(0.0));
        let period = std::f64::consts::TAU / rate;
        let (mut work, mut least, mut cycle, mut cycles) = (0.0, f64::INFINITY, 1.0, 0);
        let mut t = 0.0;
        while cycles < 40 {
            let force = -f64::from(contact.step(&config, &at(t)).force);
            // the force held over the period times the path of the hand, plus the device's own damper: any force held over
            // a period acts like a negative damping of KT/2
            let path = x(t + T) - x(t);
            work += force * path + f64::from(device.damping) * path * path / T;
            t += T;
            if t > cycle * period {
                if cycles > 1 {
                    least = least.min(work);
                }
                (work, cycle, cycles) = (0.0, cycle + 1.0, cycles + 1);
            }
        }
        println!(
            "M {mass} kg, K {k_vc} N/m, B {b_vc} N·s/m at {rate} rad/s: least work of the hand on block and device in a cycle {:.2} mJ",
            1e3 * least
        );
        assert!(least > 0.0);
    }
}
