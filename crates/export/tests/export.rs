//! What a format holds is exact, and what it does not is named with its force.

use export::{Exported, Format, export};
use identify::Model;
use signals::Recording;

const PLAIN: &str = "law = \"coulomb\"\nmass = 0.4\nf_dynamic = 1.5\ndamping = 2.0\n";

fn of(text: &str, format: Format, recording: Option<&Recording>) -> Exported {
    let model = Model::from_toml("model.toml", text).expect("a model");
    export(&model, format, recording).expect("exported")
}

/// 6 s of two sines at 1 kHz; the force is that of `PLAIN` and a spring of 60 N/m about 2 mm.
fn recording() -> Recording {
    let mut out = Recording::default();
    for i in 0..6000 {
        let t = f64::from(i) * 1e-3;
        let (mut x, mut v, mut a) = (0.0, 0.0, 0.0);
        for (r, w) in [(0.010, 9.0_f64), (0.006, 23.0)] {
            let (s, c) = (w * t).sin_cos();
            (x, v, a) = (x + r * s, v + r * w * c, a - r * w * w * s);
        }
        out.time.push(t);
        out.position.push(x);
        out.force.push(0.4 * a + 1.5 * v.signum() + 2.0 * v + 60.0 * (x - 0.002));
    }
    out
}

#[test]
fn a_plain_joint_is_held_whole() {
    for format in [Format::Mujoco, Format::Urdf] {
        let found = of(PLAIN, format, Some(&recording()));
        let j = found.joint;
        assert_eq!((j.mass, j.friction, j.damping, j.stiffness), (0.4, 1.5, 2.0, 0.0));
        assert!(found.dropped.is_empty(), "{:?}", found.dropped);
        let (model, joint) = found.error.expect("a recording");
        assert_eq!(model, joint);
    }
}

#[test]
fn a_linear_spring_is_held_by_mjcf_only() {
    let text = format!("{PLAIN}spring.stiffness = 60.0\noffset.force = -0.12\n");
    let found = of(&text, Format::Mujoco, Some(&recording()));
    assert!((found.joint.stiffness - 60.0).abs() < 1e-6, "{:?}", found.joint);
    assert!((found.joint.spring_rest - 0.002).abs() < 1e-9, "{:?}", found.joint);
    assert!(found.dropped.is_empty(), "{:?}", found.dropped);
    assert!(found.text.contains("stiffness=\"60\" springref=\"0.002\""), "{}", found.text);
    // without a spring nothing holds a constant
    let constant = of(&format!("{PLAIN}offset.force = -0.12\n"), Format::Mujoco, Some(&recording()));
    assert!((constant.dropped[0].rms.expect("a recording") - 0.12).abs() < 1e-6, "{:?}", constant.dropped);
    let found = of(&text, Format::Urdf, Some(&recording()));
    assert_eq!(found.joint.stiffness, 0.0);
    let spring = found.dropped.iter().find(|d| d.what.starts_with("spring")).expect("named");
    // rms of 60·x: 60·sqrt((0.010² + 0.006²)/2)
    let expected = 60.0 * f64::sqrt((0.010_f64.powi(2) + 0.006_f64.powi(2)) / 2.0);
    let rms = spring.rms.expect("a recording");
    assert!((rms / expected - 1.0).abs() < 0.05, "{rms} and {expected}");
}

#[test]
fn everything_else_is_named_with_its_force() {
    let text = "[preset]\nlaw = \"dahl\"\nmass = 0.4\nf_dynamic_p = 1.7\nf_dynamic_n = 1.3\ndamping = 2.0\nsigma = 30000\n\
                stribeck.force_p = 0.5\nstribeck.force_n = 0.5\nstribeck.v_s = 0.02\nstribeck.delta = 1.0\n\
                [model]\noffset = 0.1\n";
    let found = of(text, Format::Mujoco, Some(&recording()));
    let joint = found.joint;
    assert_eq!((joint.friction, joint.damping), (1.5, 2.0));
    let rms = |begins: &str| {
        let one = found.dropped.iter().find(|d| d.what.starts_with(begins));
        one.unwrap_or_else(|| panic!("{begins}: {:?}", found.dropped)).rms.expect("a recording")
    };
    assert!((rms("sensors and drive: offset") - 0.1).abs() < 1e-9);
    // ±0.2 N about the mean in each direction
    assert!((rms("direction") - 0.2).abs() < 0.02, "{}", rms("direction"));
    assert!(rms("stribeck") > 0.02 && rms("stribeck") < 0.5);
    assert!(rms("presliding") > 0.01 && rms("presliding") < 0.5);
    assert_eq!(found.dropped.len(), 4, "{:?}", found.dropped);
    for dropped in &found.dropped {
        assert!(found.text.contains(&dropped.what), "{}", dropped.what);
    }
    let none = of(text, Format::Mujoco, None);
    assert!(none.dropped.iter().all(|d| d.rms.is_none()) && none.error.is_none());
}

#[test]
fn what_no_simulator_takes_is_refused() {
    let refused = |text: &str, format| {
        let model = Model::from_toml("model.toml", text).expect("a model");
        export(&model, format, None).expect_err("refused").to_string()
    };
    assert!(refused(PLAIN, Format::Urdf).contains("accepted with a recording"));
    let massless = PLAIN.replace("0.4", "0.0");
    assert!(refused(&massless, Format::Mujoco).starts_with("mass = 0:"));
    let falling = PLAIN.replace("damping = 2.0", "damping = -2.0");
    assert!(refused(&falling, Format::Mujoco).starts_with("damping = -2:"));
    let mut other = recording();
    other.geometry = signals::Geometry::Rotary;
    let model = Model::from_toml("model.toml", PLAIN).expect("a model");
    assert!(export(&model, Format::Mujoco, Some(&other)).is_err());
}

#[test]
fn every_effect_is_held_or_named() {
    for kind in friction::effects::EffectKind::ALL {
        let mut effect = friction::effects::Effect::silent(*kind);
        for gain in kind.gains() {
            *effect.get_mut(gain.name).expect("its gain") = 0.5_f64.clamp(gain.min, gain.max);
        }
        // places apart from each other: two stops at one place are a spring
        for (i, shape) in kind.shape().iter().enumerate() {
            *effect.get_mut(shape.name).expect("its shape") += 0.02 / (i + 1) as f64;
        }
        let mut model = Model::from_toml("model.toml", PLAIN).expect("a model");
        model.set_effect(effect);
        let found = export(&model, Format::Mujoco, None).expect("exported");
        let held = found.joint.stiffness > 0.0 || found.joint.friction != 1.5 || found.joint.damping != 2.0;
        println!("{}: {}", kind.id(), if held { "held" } else { "named" });
        // of all effects only the spring is a spring
        assert_eq!(held, kind.id() == "spring", "{}", kind.id());
        assert_ne!(held, found.dropped.iter().any(|d| d.what.starts_with(kind.id())), "{}", kind.id());
    }
}
