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
    for format in [Format::Mujoco, Format::Urdf, Format::Modelica] {
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
    let found = of(text, Format::Urdf, Some(&recording()));
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

/// Numbers of an attribute of an XML text, of each element that has it.
fn attributes(text: &str, name: &str) -> Vec<Vec<f64>> {
    let begins = format!(" {name}=\"");
    let values = text.split(&begins).skip(1).filter_map(|after| after.split('"').next());
    values.map(|v| v.split(' ').map(|number| number.parse().expect("a number")).collect()).collect()
}

#[test]
fn mjcf_holds_bristles_and_waves() {
    let waves = "cogging.sine_1 = 0.15\ncogging.cosine_2 = 0.04\ncogging.wavelength = 0.02\n";
    let stribeck = |delta: f64| {
        format!(
            "stribeck.force_p = 0.5\nstribeck.force_n = 0.5\nstribeck.v_s = 0.02\nstribeck.delta = {delta}\n"
        )
    };
    let dahl = "law = \"dahl\"\nmass = 0.4\nf_dynamic = 1.5\ndamping = 2.0\nsigma = 30000\n";
    let found = of(&format!("{dahl}{}{waves}", stribeck(2.0)), Format::Mujoco, Some(&recording()));
    println!("{}", found.text);
    let lugre = attributes(&found.text, "lugre");
    // one time step of the stiffness damps the bristles
    let step = attributes(&found.text, "timestep")[0][0];
    assert_eq!(lugre[0], [30_000.0, 30_000.0 * step, 1.5, 1.5, 1.0]);
    // the fall is on bristles of 1000 rad/s
    let wanted = [0.4e6, 0.4e6 * step, 0.0005, 0.5, 0.02];
    assert!(lugre[1].iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9 * b), "{lugre:?}");
    assert!((step * f64::sqrt((30_000.0 + 0.4e6) / 0.4) - 0.06).abs() < 1e-9);
    assert!(!found.text.contains("frictionloss"), "friction twice");
    let mut cogging = attributes(&found.text, "cogging");
    cogging.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let pi = std::f64::consts::PI;
    let wanted = [[0.15, 100.0 * pi, pi], [0.04, 200.0 * pi, 1.5 * pi]];
    for (found, wanted) in cogging.iter().zip(wanted) {
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6 * b), "{found:?}, not {wanted:?}");
    }
    assert_eq!(cogging.len(), 2);
    // what is left: the reversal of the fall, and its exponent
    for (delta, ends) in [(2.0, "bend first"), (1.0, "the exponent is 2 instead of 1")] {
        let text = format!("{dahl}{}", stribeck(delta));
        let held = of(&text, Format::Mujoco, Some(&recording()));
        let [reversal] = &held.dropped[..] else { panic!("{:?}", held.dropped) };
        assert!(
            reversal.what.starts_with("reversal of stribeck") && reversal.what.ends_with(ends),
            "{reversal:?}"
        );
        let whole = of(&text, Format::Urdf, Some(&recording()));
        let whole = whole.dropped.iter().find(|d| d.what.starts_with("stribeck")).and_then(|d| d.rms);
        let (lost, whole) = (reversal.rms.expect("a recording"), whole.expect("a recording"));
        println!("fall of exponent {delta}: {lost:.4} N are lost, {whole:.4} N without it");
        assert!(lost > 0.0 && lost < whole);
    }
    // bristles beside a law without: they carry what they turn round, the rest turns at once
    let beside =
        format!("{PLAIN}presliding.force_p = 1.1\npresliding.force_n = 1.1\npresliding.x_s = 4e-5\n");
    let found = of(&beside, Format::Mujoco, Some(&recording()));
    assert!(found.dropped.is_empty(), "{:?}", found.dropped);
    let lugre = attributes(&found.text, "lugre");
    assert!((lugre[0][0] / (1.1 / 4e-5) - 1.0).abs() < 1e-6 && (lugre[0][2] - 1.1).abs() < 1e-8, "{lugre:?}");
    assert!((attributes(&found.text, "frictionloss")[0][0] - 0.4).abs() < 1e-8, "{}", found.text);
    // of two lengths the one with more of the friction
    let cable = "presliding_2.force_p = 1.2\npresliding_2.force_n = 1.2\npresliding_2.x_s = 2e-2\n";
    let found = of(&format!("{beside}{cable}"), Format::Mujoco, None);
    let dropped = found.dropped.iter().filter(|d| d.what.starts_with("presliding")).count();
    assert_eq!((attributes(&found.text, "lugre")[0][2] * 1e6).round() / 1e6, 1.2);
    assert_eq!(dropped, 1, "{:?}", found.dropped);
    // a weight on an arm is a wave of one period a turn
    let arm = format!(
        "[preset]\n{PLAIN}gravity.sine = 0.9\ngravity.cosine = 0.2\n[model]\ngeometry = \"rotary\"\n"
    );
    let [wave] = &attributes(&of(&arm, Format::Mujoco, None).text, "cogging")[..] else { panic!("one wave") };
    assert!((wave[0] - 0.9_f64.hypot(0.2)).abs() < 1e-8 && (wave[1] - 1.0).abs() < 1e-8, "{wave:?}");
    // a law of bristles that falls holds its own fall
    let lugre = "law = \"lugre\"\nmass = 0.4\nf_dynamic = 1.5\nf_static = 1.9\ndamping = 2.0\nsigma = 30000\nsigma_1 = 10\nstribeck_velocity = 0.01\n";
    let found = of(lugre, Format::Mujoco, Some(&recording()));
    assert!(found.dropped.is_empty(), "{:?}", found.dropped);
    assert_eq!(attributes(&found.text, "lugre")[0], [30_000.0, 10.0, 1.5, 1.9, 0.01]);
}

#[test]
fn what_no_simulator_takes_is_refused() {
    let refused = |text: &str, format| {
        let model = Model::from_toml("model.toml", text).expect("a model");
        export(&model, format, None).expect_err("refused").to_string()
    };
    assert!(refused(PLAIN, Format::Urdf).contains("accepted with a recording"));
    assert!(refused(PLAIN, Format::Bam).contains("accepted is a model with geometry"));
    let massless = PLAIN.replace("0.4", "0.0");
    assert!(refused(&massless, Format::Mujoco).starts_with("mass = 0:"));
    let falling = PLAIN.replace("damping = 2.0", "damping = -2.0");
    assert!(refused(&falling, Format::Mujoco).starts_with("damping = -2:"));
    let mut other = recording();
    other.geometry = signals::Geometry::Rotary;
    let model = Model::from_toml("model.toml", PLAIN).expect("a model");
    assert!(export(&model, Format::Mujoco, Some(&other)).is_err());
}

/// Rows of the table in a parameter of a Modelica text.
fn table(text: &str, parameter: &str) -> Vec<[f64; 2]> {
    let (_, after) = text.split_once(&format!("{parameter} = [")).expect("the table");
    let (rows, _) = after.split_once(']').expect("its end");
    rows.split(';')
        .map(|row| {
            let mut cells = row.split(',').map(|cell| cell.trim().parse().expect("a number"));
            [cells.next().expect("x"), cells.next().expect("F")]
        })
        .collect()
}

/// As the components interpolate: along lines.
fn between(table: &[[f64; 2]], x: f64) -> f64 {
    let after = table.partition_point(|row| row[0] < x).clamp(1, table.len() - 1);
    let ([x0, f0], [x1, f1]) = (table[after - 1], table[after]);
    f0 + (f1 - f0) * (x - x0) / (x1 - x0)
}

#[test]
fn modelica_holds_directions_break_away_and_tables() {
    let text = "law = \"coulomb\"\nmass = 0.4\nf_dynamic_p = 1.7\nf_dynamic_n = 1.3\nf_static_p = 2.0\nf_static_n = 1.6\n\
                damping = 2.0\nstribeck.force_p = 0.5\nstribeck.force_n = 0.5\nstribeck.v_s = 0.02\nstribeck.delta = 1.0\n\
                offset.force = -0.12\n\
                cogging.sine_1 = 0.3\ncogging.cosine_1 = -0.1\ncogging.wavelength = 0.004\n";
    let (recording, tolerance) = (recording(), 2e-3);
    let found = of(text, Format::Modelica, Some(&recording));
    assert!(found.dropped.is_empty(), "{:?}", found.dropped);
    let friction = table(&found.text, "f_pos");
    for v in [0.0, 1e-4, 3e-3, 0.017, 0.1, 0.23] {
        let expected = 1.5 + 2.0 * v + 0.5 * f64::exp(-v / 0.02);
        let got = between(&friction, v);
        assert!((got - expected).abs() < tolerance, "{v}: {got} and {expected}");
    }
    // at rest the table begins with 1.5 + 0.5
    assert!(found.text.contains("peak = 1.15"), "{}", found.text);
    let constant = found.text.split_once("f_constant = ").expect("a constant force").1;
    let constant: f64 = constant.split_once(')').expect("its end").0.parse().expect("a number");
    // 0.2 N against positive motion, and 0.12 N with it
    assert!((constant + 0.2 - 0.12).abs() < 1e-9, "{constant}");
    let place = table(&found.text, "place_table(table");
    for x in [-0.015, -0.0031, 0.0, 0.0077, 0.014] {
        let angle = std::f64::consts::TAU * x / 0.004;
        let expected = -(0.3 * angle.sin() - 0.1 * angle.cos());
        assert!((between(&place, x) - expected).abs() < tolerance, "{x}");
    }
    // an axis is made of the components of an axis
    let axis = of(&format!("[preset]\n{text}[model]\ngeometry = \"rotary\"\n"), Format::Modelica, None);
    assert!(axis.text.contains("BearingFriction friction(tau_pos = ["), "{}", axis.text);
    assert_eq!(axis.dropped.len(), 1, "{:?}", axis.dropped);
    assert!(axis.dropped[0].what.contains("held with --recording"), "{:?}", axis.dropped);
}

#[test]
fn modelica_holds_the_mean_of_two_directions_that_are_curves() {
    let text = format!(
        "{PLAIN}stribeck.force_p = 0.6\nstribeck.force_n = 0.4\nstribeck.v_s = 0.02\nstribeck.delta = 1.0\n"
    );
    let found = of(&text, Format::Modelica, Some(&recording()));
    assert_eq!(found.dropped.len(), 1, "{:?}", found.dropped);
    assert!(found.dropped[0].what.starts_with("direction of stribeck"), "{:?}", found.dropped);
    // ±0.1·exp(−|v|/v_s) in force, where the recording is slow
    let rms = found.dropped[0].rms.expect("a recording");
    assert!(rms > 0.005 && rms < 0.05, "{rms}");
    assert!((between(&table(&found.text, "f_pos"), 0.0) - 2.0).abs() < 1e-9);
}

#[test]
fn bam_has_the_smallest_of_its_models_that_holds_the_joint() {
    let axis = |effects: &str| {
        let text = format!("[preset]\n{PLAIN}{effects}[model]\ngeometry = \"rotary\"\n");
        let found = of(&text, Format::Bam, None);
        let json: serde_json::Value = serde_json::from_str(&found.text).expect("JSON");
        (json, found)
    };
    let stribeck =
        "stribeck.force_p = 0.5\nstribeck.force_n = 0.5\nstribeck.v_s = 0.25\nstribeck.delta = 1.4\n";
    let load = "load_dependent_friction.share = 0.07\n";
    for (effects, model) in [
        (String::new(), "m1"),
        (stribeck.to_owned(), "m2"),
        (load.to_owned(), "m3"),
        (format!("{stribeck}{load}"), "m4"),
    ] {
        let (json, found) = axis(&effects);
        println!("{json}");
        assert!(found.dropped.is_empty(), "{:?}", found.dropped);
        assert_eq!(json["model"], model);
        assert_eq!((json["armature"].as_f64(), json["friction_base"].as_f64()), (Some(0.4), Some(1.5)));
        assert_eq!(json["friction_viscous"].as_f64(), Some(2.0));
        let number = |key: &str| json[key].as_f64();
        if effects.contains("stribeck") {
            assert_eq!(number("friction_stribeck"), Some(0.5));
            assert!((number("dtheta_stribeck").expect("v_s") - 0.25).abs() < 1e-8);
            assert!((number("alpha").expect("delta") - 1.4).abs() < 1e-8);
        }
        if effects.contains("load") {
            assert_eq!(number("load_friction_base"), Some(0.07));
        }
    }
    let (json, found) = axis("spring.stiffness = 3.0\n");
    assert!(found.dropped[0].what.starts_with("spring"));
    assert!(json["not_held"][0].as_str().expect("text").starts_with("spring"));
}

#[test]
fn every_effect_is_held_or_named_in_modelica_and_bam() {
    for kind in friction::effects::EffectKind::ALL {
        let mut effect = friction::effects::Effect::silent(*kind);
        for gain in kind.gains() {
            *effect.get_mut(gain.name).expect("its gain") = 0.5_f64.clamp(gain.min, gain.max);
        }
        for (i, shape) in kind.shape().iter().enumerate() {
            *effect.get_mut(shape.name).expect("its shape") += 0.02 / (i + 1) as f64;
        }
        let mut model =
            Model::from_toml("model.toml", &format!("[preset]\n{PLAIN}[model]\ngeometry = \"rotary\"\n"))
                .expect("a model");
        model.effects.push(effect);
        let mut recording = recording();
        recording.geometry = signals::Geometry::Rotary;
        for format in [Format::Modelica, Format::Bam] {
            let found = export(&model, format, Some(&recording)).expect("exported");
            let j = found.joint;
            let plain = (j.friction, j.damping, j.stiffness, j.constant) == (1.5, 2.0, 0.0, 0.0);
            let tables = !found.by_speed.is_empty() || !found.by_place.is_empty();
            let held = !plain || tables || j.falling.force > 0.0 || j.per_load > 0.0;
            println!("{format:?} {}: {}", kind.id(), if held { "held" } else { "named" });
            assert_ne!(held, found.dropped.iter().any(|d| d.what.starts_with(kind.id())), "{}", kind.id());
        }
    }
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
        model.effects.push(effect);
        let found = export(&model, Format::Mujoco, None).expect("exported");
        let j = found.joint;
        let held = j.stiffness > 0.0
            || j.friction != 1.5
            || j.damping != 2.0
            || j.falling.force > 0.0
            || j.bristle.stiffness > 0.0
            || j.fall.stiffness > 0.0
            || !found.waves.is_empty();
        println!("{}: {}", kind.id(), if held { "held" } else { "named" });
        assert_eq!(
            held,
            ["spring", "stribeck", "presliding", "cogging", "gravity"].contains(&kind.id()),
            "{}",
            kind.id()
        );
        assert_ne!(held, found.dropped.iter().any(|d| d.what.starts_with(kind.id())), "{}", kind.id());
    }
}
