//! Recordings of simulated machines in the formats that laboratories write: what the tests of measured recordings ask,
//! asked in a plain clone; and the units of an axis.

mod plant;

use diagnose::{Diagnosis, Options, Verdict, diagnose};
use plant::{Case, Hidden, Motion, record};
use serde_json::Value;
use signals::{FaultKind, Geometry, Map, ReadOptions, Recording};
use std::collections::BTreeSet;

fn read(file: &str, map: &str) -> Recording {
    let map: Map = map.parse().expect("a map");
    Recording::read(fixtures::folder().join(file), &ReadOptions { map: Some(map), ..ReadOptions::default() })
        .expect("a recording")
}

fn found(train: &[Recording], judge: &[Recording]) -> Diagnosis {
    let found = diagnose(train, judge, &Options::default(), &|_, _| ()).expect("a diagnosis");
    println!("{}", found.summary);
    for m in &found.missing {
        println!(
            "  {}: {:.4} -> {:.4}, {:?}",
            m.effect, m.rms_heldout_before, m.rms_heldout_after, m.parameters
        );
    }
    for v in &found.validation {
        println!("  {}: {:.4} -> {:.4}", v.recording, v.relative_before, v.relative_after);
    }
    found
}

/// Whether an effect is named, or said to be indistinguishable from one that is.
fn says(found: &Diagnosis, effect: &str) -> bool {
    found.missing.iter().any(|m| m.effect == effect || m.indistinguishable_from.iter().any(|r| r == effect))
}

#[test]
fn a_positioner_with_preferred_positions() {
    let found = found(&[read("positioner.mat", fixtures::positioner::MAP)], &[]);
    assert_eq!(found.verdict, Verdict::Mismatch);
    let cogging = found.missing.iter().find(|m| m.effect == "cogging").expect("cogging");
    let [amplitude, wavelength] = fixtures::positioner::COGGING;
    let value = |name: &str| cogging.parameters[name].value;
    assert!((value("wavelength") / wavelength - 1.0).abs() < 0.01);
    assert!((value("cosine_1").hypot(value("sine_1")) / amplitude - 1.0).abs() < 0.1);
    assert!((found.after.parameters["mass"].value / fixtures::positioner::MASS - 1.0).abs() < 0.01);
    assert!(found.after.rms_heldout < 0.5 * found.baseline.rms_heldout);
}

#[test]
fn an_oscillator_has_a_nonlinear_spring_and_no_dry_friction() {
    let found = found(&[read("oscillator.mat", fixtures::oscillator::MAP)], &[]);
    assert_eq!(found.verdict, Verdict::Mismatch);
    assert!(says(&found, "nonlinear_spring"));
    for name in ["coulomb_p", "coulomb_n"] {
        let level = &found.after.parameters[name];
        println!("  {name} {:.6} ± {:.6}", level.value, level.std);
        assert!(level.value.abs() < 4.0 * level.std || level.value.abs() < 0.02 * found.baseline.rms_heldout);
    }
}

#[test]
fn a_seal_rubs_harder_under_pressure() {
    let train = ["seal_1bar.csv", "seal_3bar.csv", "seal_7bar.csv"].map(|f| read(f, fixtures::seal::MAP));
    let found = found(&train, &[read("seal_5bar.csv", fixtures::seal::MAP)]);
    assert!(found.recording_faults.iter().any(|f| f.kind == FaultKind::LostSamples));
    assert!(says(&found, "load_dependent_friction"));
    let v = &found.validation[0];
    assert!(v.relative_after < 0.5 * v.relative_before);
}

#[test]
fn a_servo_lifts_a_pendulum_against_gravity() {
    let train = ["pendulum_slow.json", "pendulum_fast.json"].map(|f| read(f, fixtures::pendulum::MAP));
    let found = found(&train, &[]);
    assert_eq!(found.verdict, Verdict::Mismatch);
    assert!(says(&found, "gravity"));
    assert!(found.after.rms_heldout < 0.1 * found.baseline.rms_heldout);
}

#[test]
fn a_stage_that_hardly_slides_has_presliding() {
    let found = found(&[read("stage.csv", fixtures::stage::MAP)], &[]);
    assert_eq!(found.missing.iter().map(|m| m.effect.as_str()).collect::<Vec<_>>(), ["presliding"]);
    let value = |name: &str| found.missing[0].parameters[name].value;
    let [force, x_s] = fixtures::stage::PRESLIDING;
    assert!((value("x_s") / x_s - 1.0).abs() < 0.02 && (value("force_p") / force - 1.0).abs() < 0.02);
    // mass and friction alone make the mass negative
    assert!(found.baseline.parameters["mass"].value < 0.0);
    assert!((found.after.parameters["mass"].value / fixtures::stage::MASS - 1.0).abs() < 0.02);
}

#[test]
fn a_tribometer_has_load_and_stribeck() {
    let found = found(&[read("tribometer.csv", fixtures::tribometer::MAP)], &[]);
    assert!(says(&found, "load_dependent_friction") && says(&found, "stribeck"));
    let of = |effect: &str| found.missing.iter().find(|m| m.effect == effect).expect("named");
    assert!(
        (of("load_dependent_friction").parameters["mu"].value / fixtures::tribometer::MU - 1.0).abs() < 0.01
    );
    let [force, speed] = fixtures::tribometer::STRIBECK;
    assert!((of("stribeck").parameters["v_s"].value / speed - 1.0).abs() < 0.1);
    assert!((of("stribeck").parameters["force_p"].value / force - 1.0).abs() < 0.1);
}

#[test]
fn a_load_that_was_not_recorded_has_no_name() {
    let without = fixtures::tribometer::MAP.split(",normal_force_n").next().expect("a map");
    let found = found(&[read("tribometer.csv", without)], &[]);
    assert_eq!(found.verdict, Verdict::Mismatch);
    assert!(found.missing.iter().all(|m| m.effect == "unnamed"));
}

/// Every text under a key `unit`.
fn units(json: &Value, out: &mut BTreeSet<String>) {
    match json {
        Value::Object(members) => {
            for (key, value) in members {
                if let (true, Some(unit)) = (key.contains("unit"), value.as_str()) {
                    out.insert(unit.to_owned());
                }
                units(value, out);
            }
        }
        Value::Array(list) => list.iter().for_each(|value| units(value, out)),
        _ => {}
    }
}

#[test]
fn a_motor_ripple_was_reported_in_metres() {
    // the same numbers on a slide and on an axis
    let hidden = [Hidden::Cubic { size: 1.5 }, Hidden::Cogging { size: 0.4, wavelength: 0.004 }];
    let slide = record(&Case { hidden, ..Case::default() }).0;
    let axis = Recording { geometry: Geometry::Rotary, ..slide.clone() };
    let of = |recording: Recording| {
        let found = found(&[recording], &[]);
        let json = serde_json::to_value(&found).expect("JSON");
        let mut all = BTreeSet::new();
        units(&json, &mut all);
        let model = found.model.expect("a model");
        println!("{all:?}\n{}", model.to_toml());
        (all, json)
    };
    let ((slide, _), (axis, json)) = (of(slide), of(axis));
    for unit in ["m", "kg", "N/m³", "N·s/m"] {
        assert!(slide.contains(unit) && !axis.contains(unit), "{unit}");
    }
    for unit in ["rad", "N·m", "kg·m²", "N·m/rad³", "N·m·s/rad"] {
        assert!(axis.contains(unit) && !slide.contains(unit), "{unit}");
    }
    let missing = json["missing"].as_array().expect("a list");
    let wavelength = missing.iter().find_map(|m| m["parameters"].get("wavelength")).expect("a wavelength");
    assert_eq!(wavelength["unit"], "rad");
}

/// `actuator_lag`, `time_skew` or `compliance` stood beside each effect: the acceleration was late, not the force.
#[test]
fn an_accelerometer_behind_its_own_low_pass_was_a_force_that_comes_early() {
    let cases = [
        Hidden::Nothing,
        Hidden::Cubic { size: 0.4 },
        Hidden::PositionFriction { size: 0.3 },
        Hidden::Drift { size: 0.3, settle: 6.0 },
    ];
    for hidden in cases {
        let case = Case {
            hidden: [hidden, Hidden::Nothing],
            motion: Motion::Chirp,
            accelerometer: Some(0.05),
            // behind by one and a half samples
            accelerometer_lag: -1e-3 / 0.6f64.ln(),
            noise_force: 0.03,
            seed: 12,
            ..Case::default()
        };
        let d = diagnose(&[record(&case).0], &[], &Options::default(), &|_, _| ()).expect("accepted");
        let named: Vec<&str> = d.missing.iter().map(|m| m.effect.as_str()).collect();
        let expected: &[&str] = match hidden {
            Hidden::PositionFriction { .. } => &["position_dependent_friction"],
            Hidden::Cubic { .. } => &["nonlinear_spring"],
            Hidden::Drift { .. } => &["friction_drift"],
            _ => &[],
        };
        let lag = d.preparation[0].channels["acceleration"].lag_s.expect("compared");
        println!("{hidden:?}: {named:?}, acceleration {:.3} ms late", 1e3 * lag.value);
        assert_eq!(named, expected, "{hidden:?}");
        assert!((lag.value - 1.5e-3).abs() < 5e-5, "{lag:?}");
    }
}
