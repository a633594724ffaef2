//! Zero-crossing limit cycle of the virtual coupling with a fixed handle: at the velocity of [thesis, eq. 4.35] for a smaller
//! Δv, absent for a larger one.

mod rig;

use haptics::{Device, LawKind, Request, Settings, bounds};
use rig::{Rig, T, control};

/// Largest |v| and |p| of the block in the last second of three, m/s and m from its middle. The block starts at the handle
/// while both move at `start`, then the handle is held: no force in the spring, as in [thesis, ch. 4.6].
fn swing(settings: &Settings, start: f64) -> (f64, f64) {
    let mut rig = Rig::of(&Device::default());
    let mut control = control(settings);
    for _ in 0..50 {
        rig.carry(start);
        control.step(None, &rig.inputs());
    }
    let (mut fastest, mut low, mut high) = (0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..3_000 {
        let request = (k == 0).then_some(&Request::Render(true));
        rig.carry(if k == 0 { start } else { 0.0 });
        let outputs = control.step(request, &rig.inputs());
        assert_eq!((outputs.fault, outputs.denied), (None, None));
        if k > 2_000 {
            let p = f64::from(outputs.block_position);
            fastest = fastest.max(f64::from(outputs.block_velocity).abs());
            (low, high) = (low.min(p), high.max(p));
        }
    }
    (fastest, 0.5 * (high - low))
}

#[test]
fn limit_cycle_has_the_velocity_of_eq_4_35() {
    for (friction, mass, k, b) in
        [(4.0, 0.5, 10_000.0, 10.0), (2.0, 0.5, 25_000.0, 10.0), (3.0, 0.4, 8_000.0, 15.0)]
    {
        let critical = bounds::limit_cycle_velocity(friction, mass, k, b, T);
        let amplitude = bounds::limit_cycle_position(friction, mass, k, b, T);
        let with = |share: f64| Settings {
            law: LawKind::Karnopp,
            f_static_p: friction as f32,
            f_static_n: friction as f32,
            f_dynamic_p: friction as f32,
            f_dynamic_n: friction as f32,
            damping_p: 0.0,
            damping_n: 0.0,
            dv: (share * critical) as f32,
            mass: mass as f32,
            k_vc: k as f32,
            b_vc: b as f32,
            ..Settings::rubber()
        };
        let warned = |share: f64| with(share).validate(&Device::default()).expect("safe").is_some();
        println!(
            "F {friction} N, M {mass} kg, K {k} N/m, B {b} N·s/m: eq. 4.35 {:.3} mm/s, vT/2 {:.3} µm",
            critical * 1e3,
            amplitude * 1e6
        );
        for start in [0.9, 1.0, 1.1] {
            let (v, p) = swing(&with(0.5), start * critical);
            let (above, _) = swing(&with(1.15), start * critical);
            println!(
                "  thrown at {start} of it: swings at {:.3} mm/s and {:.3} µm with half as much dv, {above} m/s with 15 % more",
                v * 1e3,
                p * 1e6
            );
            assert!((v / critical - 1.0).abs() < 0.02, "{v} against {critical}");
            assert!((p / amplitude - 1.0).abs() < 0.02, "{p} against {amplitude}");
            assert_eq!(above, 0.0, "stops");
        }
        assert!(warned(0.5) && !warned(1.15));
    }
}
