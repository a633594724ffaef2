//! The layout of the JSON, faults told as faults, and recordings that cannot answer.

mod plant;

use diagnose::{Diagnosis, Error, Options, Verdict, diagnose, diagnose_watched};
use plant::{Case, Hidden, record};
use serde_json::Value;
use signals::{FaultKind, Recording};
use std::cell::Cell;
use std::ops::ControlFlow;

fn run(recordings: &[Recording]) -> Diagnosis {
    diagnose(recordings, &[], &Options::default(), &|_, _| ()).expect("a diagnosis")
}

fn named(d: &Diagnosis) -> Vec<&str> {
    d.missing.iter().map(|m| m.effect.as_str()).collect()
}

fn has(value: &Value, keys: &[&str]) {
    for key in keys {
        assert!(value.get(key).is_some(), "{key} is missing in {value}");
    }
}

#[test]
fn the_json_has_every_key_of_the_design() {
    let case =
        Case { hidden: [Hidden::Stribeck { size: 0.5, speed: 0.02 }, Hidden::Nothing], ..Case::default() };
    let found = run(&[record(&case).0]);
    let json = serde_json::to_value(&found).expect("JSON");
    has(
        &json,
        &[
            "schema",
            "verdict",
            "recording_faults",
            "noise_floor",
            "baseline",
            "location",
            "missing",
            "blind_to",
            "rejected",
            "after",
            "remainder",
        ],
    );
    assert_eq!(json["schema"], "tribos.diagnosis/2");
    assert_eq!(json["verdict"], "mismatch");
    has(&json["noise_floor"], &["rms", "unit", "how"]);
    assert!(
        ["repeats", "local differences", "declared", "quantum"]
            .contains(&json["noise_floor"]["how"].as_str().expect("how"))
    );
    has(&json["baseline"], &["law", "parameters", "rms_heldout"]);
    has(&json["baseline"]["parameters"]["mass"], &["value", "std", "unit"]);
    has(&json["location"][0], &["coordinate", "from", "to", "unit", "share_of_mismatch", "p"]);
    let missing = &json["missing"][0];
    has(missing, &["effect", "says", "equation", "parameters", "rms_heldout_before", "rms_heldout_after"]);
    has(missing, &["gain_ci95", "p", "indistinguishable_from", "experiment"]);
    assert_eq!(missing["gain_ci95"].as_array().map(Vec::len), Some(2));
    has(&json["blind_to"][0], &["effect", "because", "experiment"]);
    has(&json["rejected"][0], &["effect", "upper_bound", "unit"]);
    has(&json["after"], &["rms_heldout", "free_run_error", "explained_share"]);
    has(&json["remainder"], &["rms", "located_at"]);
    assert!(
        json.get("figures").is_none() && json.get("model").is_none(),
        "the report's series stay out of the JSON"
    );
}

#[test]
fn the_report_has_its_series_and_the_model_is_a_preset() {
    let case = Case { hidden: [Hidden::Spring { size: 0.4 }, Hidden::Nothing], ..Case::default() };
    let found = run(&[record(&case).0]);
    let f = &found.figures;
    let n = f.time.len();
    assert!(
        n > 1000 && [&f.position, &f.velocity, &f.force, &f.before, &f.after].iter().all(|s| s.len() == n)
    );
    assert!(!f.curves.is_empty() && f.curves.iter().all(|c| !c.bins.is_empty()));
    let model = found.model.expect("a model");
    model.validate().expect("a model the device would take");
    let text = model.to_toml();
    println!("{text}");
    assert!(text.contains("spring.stiffness"));
}

#[test]
fn lost_samples_are_a_fault_and_not_physics() {
    let (whole, _) = record(&Case::default());
    let keep = |s: &[f64]| -> Vec<f64> {
        let lost = |i: usize| (5000..5037).contains(&i) || (9100..9103).contains(&i);
        s.iter().enumerate().filter(|(i, _)| !lost(*i)).map(|(_, x)| *x).collect()
    };
    let cut = Recording {
        time: keep(&whole.time),
        position: keep(&whole.position),
        force: keep(&whole.force),
        ..whole.clone()
    };
    let found = run(&[cut]);
    println!("{:?} {:?} {:?}", found.verdict, named(&found), found.recording_faults);
    assert!(found.recording_faults.iter().any(|f| f.kind == FaultKind::LostSamples));
    assert_eq!(found.verdict, Verdict::NoMismatch);
}

#[test]
fn samples_lost_one_by_one_left_nothing_to_fit() {
    let case =
        Case { hidden: [Hidden::Stribeck { size: 0.5, speed: 0.02 }, Hidden::Nothing], ..Case::default() };
    let (whole, _) = record(&case);
    // one of six
    let keep = |s: &[f64]| -> Vec<f64> {
        s.iter().enumerate().filter(|(i, _)| (i * i * 7 + i) % 12 != 8).map(|(_, x)| *x).collect()
    };
    let cut = Recording {
        time: keep(&whole.time),
        position: keep(&whole.position),
        force: keep(&whole.force),
        ..whole.clone()
    };
    println!("{} of {} samples", cut.len(), whole.len());
    let found = run(&[cut]);
    println!("{:?} {:?} {:?}", found.verdict, named(&found), found.recording_faults);
    assert_eq!(named(&found), ["stribeck"]);
    assert!(found.recording_faults.iter().any(|f| f.why.contains("are put in")));
    let before = run(&[whole]);
    let share = found.after.rms_heldout / before.after.rms_heldout;
    println!("what is left: {share:.3} of that of the whole recording");
    // fewer samples average less noise: by a tenth, and what is put in has the noise of its neighbours
    assert!((1.0..1.25).contains(&share), "{share}");
}

#[test]
fn a_wrong_velocity_column_is_a_fault_and_not_physics() {
    let (mut recording, _) = record(&Case::default());
    let x = &recording.position;
    let n = x.len();
    let slope = |i: usize| (x[(i + 8).min(n - 1)] - x[i.saturating_sub(8)]) / 0.016;
    recording.velocity = Some((0..n).map(|i| 1.25 * slope(i)).collect());
    let found = run(&[recording]);
    println!("{:?} {:?} {:?}", found.verdict, named(&found), found.recording_faults);
    let wrong = [FaultKind::VelocityScale, FaultKind::VelocityMismatch];
    assert!(found.recording_faults.iter().any(|f| wrong.contains(&f.kind)));
    assert_eq!(found.verdict, Verdict::NoMismatch);
}

#[test]
fn what_cannot_answer_says_so_and_never_panics() {
    let (whole, _) = record(&Case { seconds: 4.0, ..Case::default() });
    let n = whole.time.len();
    let first = |count: usize| Recording {
        time: whole.time[..count].to_vec(),
        position: whole.position[..count].to_vec(),
        force: whole.force[..count].to_vec(),
        ..whole.clone()
    };
    let cases: [(&str, Recording); 7] = [
        ("empty", first(0)),
        ("one sample", first(1)),
        ("short", first(100)),
        ("at rest", Recording { position: vec![0.01; n], ..whole.clone() }),
        ("no force", Recording { force: vec![f64::NAN; n], ..whole.clone() }),
        ("infinite", Recording { position: vec![f64::INFINITY; n], ..whole.clone() }),
        ("no time", Recording { time: vec![0.0; n], ..whole.clone() }),
    ];
    for (name, recording) in cases {
        let found = run(&[recording]);
        println!("{name}: {}", found.summary);
        assert_eq!(found.verdict, Verdict::NotTestable, "{name}");
        assert!(found.missing.is_empty(), "{name}");
        serde_json::to_string(&found).expect("JSON");
    }
    assert!(diagnose(&[], &[], &Options::default(), &|_, _| ()).is_err());
}

#[test]
fn a_watch_ends_it_wherever_it_is() {
    let case =
        Case { hidden: [Hidden::Stribeck { size: 0.5, speed: 0.02 }, Hidden::Nothing], ..Case::default() };
    let recordings = [record(&case).0];
    let told = Cell::new(0);
    let until = |last: usize| {
        told.set(0);
        diagnose_watched(&recordings, &[], &Options::default(), &|_, _| {
            told.set(told.get() + 1);
            if told.get() >= last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    };
    assert!(until(usize::MAX).is_ok());
    let all = told.get();
    assert!(all >= 10, "{all}");
    for last in [1, 2, all / 4, all / 2, 3 * all / 4, all] {
        assert_eq!(until(last).err(), Some(Error::Interrupted), "{last} of {all}");
        assert_eq!(told.get(), last, "it went on");
    }
}

#[test]
fn a_few_bad_samples_do_not_change_the_answer() {
    let case =
        Case { hidden: [Hidden::Stribeck { size: 0.5, speed: 0.02 }, Hidden::Nothing], ..Case::default() };
    let (mut recording, _) = record(&case);
    recording.force[4000] = f64::NAN;
    recording.position[8000] = f64::INFINITY;
    let found = run(&[recording]);
    println!("{:?} {:?}", named(&found), found.recording_faults);
    assert_eq!(named(&found).first(), Some(&"stribeck"));
    assert!(found.recording_faults.iter().any(|f| f.kind == FaultKind::NotANumber));
}
