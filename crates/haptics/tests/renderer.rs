//! The rendered contact on the exact device of [thesis, eq. 4.15]: holding, break-away, sliding, stopping, swapping.

mod rig;

use haptics::{Control, Device, FaultKind, LawKind, RendererKind, Settings, bounds};
use rig::{COUNT, Rig, T, control, render};

/// The first four laws with every renderer, symmetric, within the range of the rig. The others: tests/laws.rs.
fn contacts() -> Vec<(String, Settings)> {
    let mut all = Vec::new();
    for law in [LawKind::Karnopp, LawKind::Dahl, LawKind::Coulomb, LawKind::LuGre] {
        for &renderer in RendererKind::ON_BOARD {
            let settings = Settings {
                law,
                renderer,
                f_static_p: 3.5,
                f_static_n: 3.5,
                f_dynamic_p: 3.0,
                f_dynamic_n: 3.0,
                damping_p: 4.0,
                damping_n: 4.0,
                dv: 0.01,
                mass: 0.4,
                sigma: 8_000.0,
                sigma_1: 10.0,
                stribeck_velocity: 0.005,
                ..Settings::rubber()
            };
            all.push((format!("{} {}", law.id(), renderer.id()), settings));
        }
    }
    all
}

#[test]
fn holds_below_break_away_without_creep() {
    for (name, settings) in contacts() {
        // bristles hold at most the dynamic level permanently
        let push = if !settings.law.holds() { 2.5 } else { 3.2 };
        let mut rig = Rig::of(&Device::default());
        let mut control = control(&settings);
        let mut outputs = render(&mut control, &mut rig);
        let mut held = (0.0, 0.0, 0.0);
        let (mut low, mut high, mut still) = (f32::INFINITY, f32::NEG_INFINITY, true);
        for k in 0..10_000 {
            // 1 s to reach the load, like a hand
            rig.push(f64::from(outputs.force) + push * (f64::from(k) * 1e-3).min(1.0));
            outputs = control.step(None, &rig.inputs());
            assert_eq!(outputs.fault, None, "{name} at {k}");
            if k == 6_000 {
                held = (rig.x, f64::from(outputs.block_position), f64::from(outputs.force));
            }
            if k > 6_000 {
                (low, high) = (low.min(outputs.force), high.max(outputs.force));
                still &= outputs.block_velocity == 0.0;
            }
        }
        let creep = rig.x - held.0;
        println!(
            "{name:26} holds {push} N at {:.3} mm: creep in 4 s {:.2} µm, force {:.3} N, ripple {:.4} N, stuck {}",
            rig.x * 1e3,
            creep * 1e6,
            outputs.force,
            high - low,
            outputs.stuck
        );
        assert!(outputs.stuck, "{name}");
        if !settings.law.holds() {
            // bristle laws drift when an encoder edge toggles: known, bounded, documented
            assert!(creep.abs() < 2e-3, "{name} drifts {creep} m");
            continue;
        }
        assert!(creep.abs() < 1.5 * COUNT, "{name} creeps {creep} m");
        assert!((f64::from(outputs.force) + push).abs() < 0.05, "{name} balances");
        assert!(high - low < 0.06, "{name}: one count of the encoder at most is heard");
        if settings.renderer.has_block() {
            assert!(still, "{name}: the block is at rest exactly");
            assert_eq!(f64::from(outputs.block_position), held.1, "{name}: not one bit");
        }
    }
}

#[test]
fn breaks_away_at_the_static_level() {
    for (name, settings) in contacts() {
        if settings.law == LawKind::Dahl {
            continue; // has no break-away
        }
        for sign in [1.0, -1.0] {
            let mut rig = Rig::of(&Device::default());
            let mut control = control(&settings);
            let mut outputs = render(&mut control, &mut rig);
            let mut broke = f64::NAN;
            for k in 0..10_000 {
                let push = sign * 0.5e-3 * f64::from(k);
                rig.push(f64::from(outputs.force) + push);
                outputs = control.step(None, &rig.inputs());
                // bristles yield before they break away
                if !outputs.stuck && outputs.block_velocity != 0.0 {
                    broke = push;
                    break;
                }
            }
            println!("{name:26} breaks away at {broke:+.3} N (static 3.5)");
            assert!((broke.abs() - 3.5).abs() < 0.12, "{name}");
        }
    }
}

#[test]
fn slides_at_dynamic_plus_viscous_friction() {
    for (name, mut settings) in contacts() {
        if settings.law != LawKind::LuGre {
            (settings.f_dynamic_n, settings.f_static_n) = (2.0, 2.4);
        }
        for v in [0.02, 0.05, -0.02, -0.05] {
            let level = if v > 0.0 || settings.law == LawKind::LuGre { 3.0 } else { 2.0 };
            let expected = -(level * f64::signum(v) + 4.0 * v);
            let mut rig = Rig::new(0.692, 6.92, -f64::signum(v) * 0.014);
            let mut control = control(&settings);
            render(&mut control, &mut rig);
            let (mut sum, mut square, mut n) = (0.0, 0.0, 0.0);
            let steps = (0.026 / f64::abs(v) / T) as u32;
            for k in 0..steps {
                rig.carry(v);
                let outputs = control.step(None, &rig.inputs());
                assert_eq!(outputs.fault, None, "{name} at {v} m/s");
                if k > steps / 2 {
                    let error = f64::from(outputs.force) - expected;
                    (sum, square, n) = (sum + error, square + error * error, n + 1.0);
                }
            }
            let (mean, rms): (f64, f64) = (sum / n, f64::sqrt(square / n));
            println!(
                "{name:26} at {v:+.2} m/s: {expected:+.3} N expected, mean error {mean:+.4}, rms {rms:.4} N"
            );
            assert!(mean.abs() < 0.02 && rms < 0.05, "{name}");
        }
    }
}

#[test]
fn the_block_stops_above_its_limit_cycle() {
    // the handle is pulled aside by 1 mm and held: the block follows and must come to rest
    let settings = Settings { f_dynamic_p: 3.0, f_dynamic_n: 3.0, f_static_n: 3.5, ..Settings::rubber() };
    let critical = bounds::limit_cycle_velocity(
        3.0,
        f64::from(settings.mass),
        f64::from(settings.k_vc),
        f64::from(settings.b_vc),
        T,
    );
    for law in [LawKind::Karnopp, LawKind::Coulomb] {
        let settings = Settings { law, dv: (critical * 1.05) as f32, ..settings };
        let mut rig = Rig::of(&Device::default());
        let mut control = control(&settings);
        render(&mut control, &mut rig);
        let (mut moving, mut reversals, mut last) = (0, 0, 0.0_f32);
        for k in 0..3_000 {
            rig.carry(if k < 20 { 0.05 } else { 0.0 });
            let outputs = control.step(None, &rig.inputs());
            if k > 100 {
                moving += u32::from(outputs.block_velocity != 0.0);
            }
            reversals += u32::from(last * outputs.block_velocity < 0.0);
            last = outputs.block_velocity;
        }
        println!(
            "{}: limit cycle of eq. 4.35 {:.2} mm/s, dv {:.2}: moving samples after 80 ms {moving}, reversals {reversals}",
            law.id(),
            critical * 1e3,
            settings.dv * 1e3
        );
        assert_eq!(moving, 0, "no limit cycle");
    }
}

#[test]
fn the_stiffness_bound_is_tight() {
    // stuck handle after a short push; K_p from [thesis, eq. 4.18] for the test device, b_vc = 0
    let device = Device::default();
    let limit = bounds::kp_max(f64::from(device.mass), f64::from(device.damping), T);
    let settings = |k: f32| Settings {
        renderer: RendererKind::Impedance,
        b_vc: 0.0,
        k_vc: k,
        f_static_p: 9.0,
        f_static_n: 9.0,
        ..Settings::rubber()
    };
    let swing = |k: f32, damping: f64| {
        let mut rig = Rig::new(0.692, damping, 0.5 * COUNT);
        let mut control = control(&settings(k));
        let mut outputs = render(&mut control, &mut rig);
        let (mut early, mut late) = (0.0_f64, 0.0_f64);
        for step in 0..8_000 {
            let pluck = if step < 5 { 2.0 } else { 0.0 };
            rig.push(f64::from(outputs.force) + pluck);
            outputs = control.step(None, &rig.inputs());
            if outputs.amplifier && (100..300).contains(&step) {
                early = early.max(rig.x.abs());
            }
            if step > 7_000 {
                late = late.max(rig.x.abs());
            }
        }
        (early, late)
    };
    let (early, late) = swing((limit * 0.95) as f32, 6.92);
    let (early_beyond, late_beyond) = swing((limit * 0.95) as f32, 6.92 * 0.8);
    println!("K_p = 0.95 of {limit:.0} N/m: swing {:.1} µm decays to {:.1} µm", early * 1e6, late * 1e6);
    println!(
        "the same K_p, device damping 20 % smaller: {:.1} µm grows to {:.1} µm",
        early_beyond * 1e6,
        late_beyond * 1e6
    );
    assert!(late < 0.2 * early);
    assert!(late_beyond > 1.5 * early_beyond);
    let refused = settings((limit * 1.01) as f32).validate(&device).expect_err("above the bound");
    println!("above it: {refused}");
}

#[test]
fn a_swapped_configuration_does_not_jump() {
    for (name, settings) in contacts() {
        let mut rig = Rig::of(&Device::default());
        let mut control = control(&settings);
        let mut outputs = render(&mut control, &mut rig);
        let hold = |control: &mut Control, rig: &mut Rig, outputs: &mut haptics::Outputs, steps: u32| {
            for _ in 0..steps {
                rig.push(f64::from(outputs.force) + 1.5);
                *outputs = control.step(None, &rig.inputs());
            }
        };
        hold(&mut control, &mut rig, &mut outputs, 1_500);
        let before = outputs.force;
        let mut worst = 0.0_f32;
        for (_, other) in contacts() {
            control.configure(other.build(&Device::default()).expect("valid"));
            let last = outputs.force;
            rig.push(f64::from(outputs.force) + 1.5);
            outputs = control.step(None, &rig.inputs());
            worst = worst.max((outputs.force - last).abs());
            hold(&mut control, &mut rig, &mut outputs, 1_500);
        }
        println!("{name:26} at {before:.3} N: largest jump over {} swaps {worst:.3} N", contacts().len());
        assert!(worst < 0.35, "{name} jumps {worst} N");
        assert_eq!(outputs.fault, None);
    }
}

#[test]
fn force_is_clamped_and_a_runaway_released() {
    let settings = Settings { damping_p: 35.0, damping_n: 35.0, mass: 0.5, ..Settings::rubber() };
    let mut rig = Rig::new(0.692, 6.92, -0.015);
    let mut control = control(&settings);
    render(&mut control, &mut rig);
    let (mut largest, mut fault) = (0.0_f32, None);
    for k in 0..60 {
        rig.carry(0.5 + 0.015 * f64::from(k));
        let outputs = control.step(None, &rig.inputs());
        largest = largest.max(outputs.force.abs());
        assert!(outputs.force.abs() <= 9.48);
        if let Some(kind) = outputs.fault {
            assert_eq!((outputs.force, outputs.amplifier), (0.0, false), "in the same step");
            fault.get_or_insert(kind);
        }
    }
    println!("largest force {largest} N, then {fault:?}");
    assert_eq!(largest, 9.48);
    assert!(matches!(fault, Some(FaultKind::Overspeed | FaultKind::EndOfStroke)));
}
