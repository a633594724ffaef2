//! The open world in small: forces that are in nobody's catalogue, hidden by the prover's own plant.

use prove::{Extent, Run};
use serde_json::Value;
use untested::draws;

fn cases(name: &str, effects: &[&str], (seeds, seed): (u64, u64), strength: f64) -> Vec<Value> {
    let folder = std::env::temp_dir().join(format!("tribos-open-{name}-{}", std::process::id()));
    let extent = Extent {
        seeds,
        seed,
        strengths: vec![strength],
        seconds: 16.0,
        effects: effects.iter().map(|e| (*e).to_string()).collect(),
        companions: false,
        open: true,
    };
    let quiet = |_: &str, _: usize, _: usize| {};
    let run = Run::begin(&folder, extent).unwrap();
    run.seal(&quiet).unwrap();
    run.answer(|| true, &quiet).unwrap();
    let (proof, answered) = run.open_labels(&quiet).unwrap().expect("answered");
    assert_eq!(answered, run.count());
    println!("{}", proof.describe());
    let text = std::fs::read_to_string(folder.join("prove.json")).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    let proof: Value = serde_json::from_str(&text).unwrap();
    proof["cases"].as_array().unwrap().clone()
}

#[test]
fn what_is_in_nobodys_catalogue_is_a_curve_that_predicts_the_next_motion() {
    let effects = ["one_sided_spring", "random_position_friction", "detent"];
    for case in cases("curve", &effects, (1, 12), 3.0) {
        let named: Vec<&str> = case["named"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        if case["kind"] == "null" {
            assert!(named.is_empty(), "nothing is hidden: {named:?}");
            continue;
        }
        assert_eq!(named, ["unnamed"], "{}", case["hidden"]);
        assert_eq!(case["located"], true, "{}", case["hidden"]);
        let explained = case["explained"].as_f64().unwrap();
        assert!(explained > 0.9, "{}: {explained:.3} of the next motion", case["hidden"]);
    }
}

#[test]
fn a_part_of_something_unknown_was_told_as_compliance_backlash_or_rising_static_friction() {
    let effects = ["random_acceleration", "heated_by_sliding", "random_slid"];
    for case in cases("part", &effects, (draws(1, 2).end, 302), 2.0) {
        let named = case["named"].as_array().unwrap();
        assert!(named.iter().all(|n| n == "unnamed"), "{}: {named:?}", case["hidden"]);
        assert_eq!(named.is_empty(), case["kind"] == "null", "{}", case["hidden"]);
    }
}

#[test]
fn an_eddy_current_brake_was_viscous_friction_that_rises_faster_than_the_speed() {
    for case in cases("brake", &["eddy_current_brake"], (draws(1, 2).end, 1), 2.0) {
        let named = case["named"].as_array().unwrap();
        assert!(named.iter().all(|n| n == "unnamed"), "{}: {named:?}", case["hidden"]);
        assert_eq!(named.is_empty(), case["kind"] == "null", "{}", case["hidden"]);
    }
}

/// Friction that is another from a moment on was told as a drift of seconds; what acted for a second only, as no mismatch.
#[test]
fn what_happened_once_was_a_drift_or_nothing() {
    for case in cases("once", &["friction_steps_once", "cable_caught_once"], (draws(1, 2).end, 41), 2.0) {
        let named = case["named"].as_array().unwrap();
        if case["kind"] == "null" {
            assert!(named.is_empty(), "nothing is hidden: {named:?}");
            continue;
        }
        assert!(named.len() == 1 && named[0] == "unnamed", "{}: {named:?}", case["hidden"]);
        assert_eq!(case["located"], true, "{}", case["hidden"]);
        let explained = case["explained"].as_f64().unwrap();
        let steps = case["hidden"].to_string().contains("friction_steps_once");
        assert!(explained > 0.9 || !steps, "{}: {explained:.3} of the next motion", case["hidden"]);
    }
}
