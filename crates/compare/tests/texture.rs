//! Force over position that is known: forces are written down from the motion, not by a law of this workspace.

use compare::{Comparison, Kind, MARGIN, Measured, Verdict, compare};
use signals::Recording;
use std::f64::consts::{PI, TAU};
use untested::draws;

/// What repeats over position.
#[derive(Clone, Copy)]
struct Pattern {
    /// Amplitudes of two harmonics, N.
    sizes: [f64; 2],
    /// m.
    period: f64,
    /// Of the zero of position, rad.
    phase: f64,
    /// −1 for a friction: it turns with the direction.
    reverse: f64,
}

const SMOOTH: Pattern = Pattern { sizes: [0.0; 2], period: 0.003, phase: 0.0, reverse: 1.0 };
const DETENTS: Pattern = Pattern { sizes: [0.8, 0.0], ..SMOOTH };

/// A block of 0.3 kg with friction of 1 N and 2 N·s/m, moved to and fro by a hand that is never the same twice; position in
/// steps of 1 µm, force with a noise of 0.06 N.
fn recording(pattern: Pattern, seed: u64) -> Recording {
    let mut noise = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut jitter = move || {
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (noise >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut recording = Recording { name: format!("{seed}.csv"), ..Recording::default() };
    let (wander, at) = (TAU * (0.13 + 0.02 * jitter()), TAU * jitter());
    for i in 0..20_000 {
        let t = f64::from(i) * 1e-3;
        let wave = |size: f64, turn: f64, phase: f64| {
            let (sine, cosine) = (turn * t + phase).sin_cos();
            [size * sine, size * turn * cosine, -size * turn * turn * sine]
        };
        let (main, slow) = (wave(0.011, TAU * 0.6, 0.0), wave(0.002, wander, at));
        let [x, v, a] = [0, 1, 2].map(|k| main[k] + slow[k]);
        let place = TAU * x / pattern.period + pattern.phase;
        let texture = pattern.sizes[0] * place.cos() + pattern.sizes[1] * (2.0 * place).cos();
        let way = if v < 0.0 { pattern.reverse } else { 1.0 };
        recording.time.push(t);
        recording.position.push((x * 1e6).round() * 1e-6);
        recording.force.push(0.3 * a + v.signum() + 2.0 * v + way * texture + 0.2 * jitter());
    }
    recording
}

fn measured(pattern: Pattern, seed: u64) -> Measured {
    Measured::new(&recording(pattern, seed)).unwrap_or_else(|e| panic!("{e}"))
}

fn compared(real: &Measured, rendered: &Measured) -> Comparison {
    compare(real, rendered, None, MARGIN).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn smooth_blocks_have_no_texture() {
    let real = measured(SMOOTH, 100);
    for seed in draws(2, 20) {
        let c = compared(&real, &measured(SMOOTH, seed));
        assert!(c.texture.is_none() && c.overall() == c.verdict, "{seed}: {:?}", c.texture);
    }
}

#[test]
fn same_texture_with_new_noise_and_phase_is_same() {
    for (name, pattern) in [
        ("detents", DETENTS),
        ("grain", Pattern { reverse: -1.0, ..DETENTS }),
        ("ratchet", Pattern { sizes: [0.8, 0.4], period: 0.004, ..SMOOTH }),
        ("linen", Pattern { sizes: [0.3, 0.0], period: 0.001, reverse: -1.0, ..SMOOTH }),
    ] {
        let real = measured(pattern, 100);
        let mut verdicts = Vec::new();
        for seed in draws(2, 20) {
            let other = Pattern { phase: PI * (0.37 * seed as f64).sin() + 3.0, ..pattern };
            let c = compared(&real, &measured(other, seed));
            let t = c.texture.unwrap_or_else(|| panic!("{name} {seed}: no texture"));
            let d = &t.directions[0];
            println!(
                "{name:8} {:.3} JND ({:.3} to {:.3}), {:.3} mm, {:.4} N against {:.4} N, ratio {:.3?}, overlap {:.4?}, period {:.5?}",
                t.distance.value,
                t.distance.ci95[0],
                t.distance.ci95[1],
                1e3 * t.period[1].unwrap_or(0.0),
                d.rendered,
                d.real,
                d.ratio.map(|r| r.ci95),
                d.overlap.map(|r| r.ci95),
                t.period_ratio.map(|r| r.ci95)
            );
            let power = pattern.sizes[0].hypot(pattern.sizes[1]);
            assert!((d.rendered / power - 1.0).abs() < 0.03, "{d:?}");
            assert!(t.distance.ci95[1] < 1.0);
            let kind = if pattern.reverse > 0.0 { Kind::Force } else { Kind::Friction };
            // a coupling could turn a period of a millimetre as far
            assert_eq!(t.kind, [(name != "linen").then_some(kind); 2]);
            verdicts.push(t.verdict);
        }
        assert!(verdicts.iter().all(|v| *v == Verdict::Same), "{name}: {verdicts:?}");
    }
}

#[test]
fn amplitude_period_and_shape_each_make_a_difference() {
    let ratchet = Pattern { sizes: [0.8, 0.4], ..SMOOTH };
    let twice = Pattern { sizes: [1.6, 0.0], ..DETENTS };
    let longer = Pattern { period: 0.0033, ..DETENTS };
    for (name, one, other) in [
        ("twice as strong", DETENTS, twice),
        ("half as strong", twice, DETENTS),
        ("another period", DETENTS, longer),
        ("another shape", DETENTS, Pattern { sizes: [0.7, 0.4], ..SMOOTH }),
        ("a friction", ratchet, Pattern { reverse: -1.0, ..ratchet }),
        ("none", DETENTS, SMOOTH),
        ("one instead of none", SMOOTH, DETENTS),
    ] {
        for seed in draws(1, 3) {
            let c = compared(&measured(one, 100 + seed), &measured(other, seed));
            let t = c.texture.clone().unwrap_or_else(|| panic!("{name} {seed}: no texture"));
            if seed == 0 {
                println!("{name}: {t:#?}");
            }
            assert_eq!(t.verdict, Verdict::Different, "{name} {seed}: {t:?}");
            assert_eq!(c.overall(), Verdict::Different);
            let text = format!("{t:?}");
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
            if name == "twice as strong" {
                // level 1.1 N and amplitude 0.8 N: a JND of 0.19 N
                let d = &t.directions[0];
                assert!((d.ratio.expect("a ratio").value - 2.0).abs() < 0.03, "{d:?}");
                assert!((d.jnd - 0.19).abs() < 0.01, "{d:?}");
                assert!((t.distance.value - 0.8 / d.jnd).abs() < 0.1 * t.distance.value, "{t:?}");
            }
        }
    }
}
