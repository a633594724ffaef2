//! The same law in f32, as on the device, and in f64, as in the rig.

use crate::common::{laws, surface};
use friction::effects::{Effect, EffectKind};
use friction::{Dahl, Dimension, FrictionLaw, Law, LawKind, Motion, Surface};

fn narrowed(law: &Law<f64>) -> Law<f32> {
    let wide = Surface::of(law);
    let mut narrow = Surface { adhesion: wide.adhesion, ..Surface::default() };
    for name in Surface::<f64>::NAMES {
        *narrow.get_mut(name).expect("a name") = wide.get(name).expect("a name") as f32;
    }
    narrow.law(law.kind())
}

fn widened(m: &Motion<f32>) -> Motion<f64> {
    Motion {
        dt: m.dt.into(),
        position: m.position.into(),
        displacement: m.displacement.into(),
        velocity: m.velocity.into(),
        applied: m.applied.into(),
        mass: m.mass.into(),
        normal: m.normal.map(f64::from),
    }
}

/// A 2 Hz sine with a ripple that reverses within it, as f32 sees it.
fn motion(k: usize) -> Motion<f32> {
    let at = |k: usize| {
        let t = k as f32 * 1e-3;
        0.01 * libm_sin(12.566 * t) + 2e-4 * libm_sin(301.0 * t)
    };
    let displacement = at(k + 1) - at(k);
    Motion {
        dt: 1e-3,
        position: at(k + 1),
        displacement,
        velocity: displacement / 1e-3,
        applied: 4.0 * libm_sin(17.0 * k as f32 * 1e-3),
        mass: 0.0,
        normal: Some(4.1),
    }
}

fn libm_sin(x: f32) -> f32 {
    friction::Scalar::sin(x)
}

#[test]
fn laws_agree() {
    let mut all: Vec<Law<f64>> = laws().iter().map(|(law, ..)| *law).collect();
    all.push(Law::Dahl(Dahl { exponent: 1.7, ..crate::common::dahl() }));
    // a bond that snaps one step later in f32 forms again elsewhere
    let others = LawKind::ALL.iter().filter(|kind| **kind != LawKind::Bristle);
    all.extend(others.map(|kind| surface().law(*kind)));
    for law in all {
        let device = narrowed(&law);
        let (mut narrow, mut wide) = (Default::default(), Default::default());
        let mut worst = 0.0_f64;
        for k in 0..20_000 {
            let m = motion(k);
            let f = device.step(&mut narrow, &m);
            let g = law.step(&mut wide, &widened(&m));
            worst = worst.max((f64::from(f) - g).abs());
        }
        println!("{:17} f32 against f64 over 20 s: at most {worst:.1e} N", law.id());
        assert!(worst < 2e-4, "{} differs by {worst} N", law.id());
    }
}

/// An effect with ordinary parameters, unlike in every direction.
fn example(kind: EffectKind) -> Effect<f64> {
    let mut effect = Effect { kind, gains: [0.0; 4], shape: [0.0; 2] };
    for (k, (gain, parameter)) in effect.gains.iter_mut().zip(kind.gains()).enumerate() {
        *gain = (0.5 + 0.25 * k as f64).clamp(parameter.min, parameter.max);
    }
    let shape = [("x_max", 0.005), ("x_min", -0.004), ("wavelength", 0.0037), ("v_s", 0.02), ("v_0", 0.05)];
    for (value, parameter) in effect.shape.iter_mut().zip(kind.shape()) {
        let named = shape.iter().find(|(name, _)| *name == parameter.name).map(|(_, value)| *value);
        *value = named.unwrap_or(if parameter.dimension == Dimension::NUMBER {
            1.3_f64.clamp(parameter.min, parameter.max)
        } else {
            (parameter.min * parameter.max).sqrt()
        });
    }
    effect.validate().expect("a valid example");
    effect
}

#[test]
fn effects_agree() {
    for &kind in EffectKind::ALL {
        let effect = example(kind);
        let device =
            Effect { kind, gains: effect.gains.map(|g| g as f32), shape: effect.shape.map(|s| s as f32) };
        device.validate().expect("renderable");
        let (mut narrow, mut wide) = (Default::default(), Default::default());
        let (mut worst, mut most) = (0.0_f64, 0.0_f64);
        for k in 0..20_000 {
            let m = motion(k);
            let f = device.step(&mut narrow, &m);
            let g = effect.step(&mut wide, &widened(&m));
            assert!(f.is_finite());
            worst = worst.max((f64::from(f) - g).abs());
            most = most.max(g.abs());
        }
        println!("{:28} at most {most:8.5} N, f32 differs by {worst:.1e} N", kind.id());
        assert!(most > 0.0, "{} does nothing", kind.id());
        // frictional_lag jumps where the lagged velocity crosses zero, which may be one sample apart
        assert!(worst < 1e-4 * (1.0 + most) || kind == EffectKind::FrictionalLag);
    }
}
