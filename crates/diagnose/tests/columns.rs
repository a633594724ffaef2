//! Further columns of a file: another joint's position, a force inside the machine.

mod plant;

use diagnose::{Diagnosis, Options, Verdict, diagnose};
use plant::{Case, Hidden, STROKE, record};
use signals::Recording;

fn answer(train: &Recording, judge: &[Recording]) -> Diagnosis {
    let found = diagnose(std::slice::from_ref(train), judge, &Options::default(), &|_, _| ()).unwrap();
    println!("{}", found.summary);
    found
}

/// Another joint that swings by itself, and pulls on this body by `pull` newtons at 1 rad.
fn coupled(seed: u64, pull: f64) -> Recording {
    let (mut recording, _) = record(&Case { seed, ..Case::default() });
    let angle = |t: &f64| 0.8 * (2.9 * t + 0.4).sin() + 0.5 * (7.3 * t).sin();
    let q2: Vec<f64> = recording.time.iter().map(angle).collect();
    for (f, q) in recording.force.iter_mut().zip(&q2) {
        *f += pull * q.sin();
    }
    recording.extra.insert("q2_rad".into(), q2);
    recording
}

#[test]
fn an_error_that_follows_another_joint_is_told_of_its_column() {
    let found = answer(&coupled(4, 0.6), &[coupled(5, 0.6)]);
    assert_eq!(found.verdict, Verdict::Mismatch);
    assert!(found.missing[0].says.contains("follows q2_rad"), "{}", found.missing[0].says);
    assert_eq!(found.location[0].coordinate, "q2_rad");
    let names: Vec<&str> = found.missing.iter().map(|m| m.effect.as_str()).collect();
    assert!(names.iter().all(|n| *n == "unnamed"), "{names:?}");
    // the baseline is the simulation that knows nothing of the other joint, here and on the next record
    let v = &found.validation[0];
    println!(
        "{:.3} -> {:.3}, frozen {:.3} -> {:.3}",
        found.baseline.rms_heldout, found.after.rms_heldout, v.rms_before, v.rms_after
    );
    assert!(found.baseline.rms_heldout > 0.3 && found.after.rms_heldout < 0.05);
    assert!(v.rms_before > 0.3 && v.rms_after < 0.05);
}

#[test]
fn a_column_that_is_followed_in_one_record_only_made_the_next_one_worse() {
    let found = answer(&coupled(4, 0.6), &[coupled(5, -0.6)]);
    let v = &found.validation[0];
    assert!(v.rms_after <= v.rms_before, "{} -> {}", v.rms_before, v.rms_after);
    assert!(
        found.does_not_carry_over.iter().any(|c| c.effect == "unnamed"),
        "{:?}",
        found.does_not_carry_over
    );
}

/// A force inside the machine that follows its friction had the friction's error ascribed to it, and no effect was named.
#[test]
fn friction_is_a_rival_of_a_force_inside_the_machine_that_follows_it() {
    let hidden = [Hidden::Bristles { size: 0.6, reach: 0.1 * STROKE }, Hidden::Nothing];
    let (mut recording, hidden) = record(&Case { hidden, ..Case::default() });
    let inside = hidden.iter().enumerate().map(|(i, h)| 3.0 * h + 0.8 * (0.013 * i as f64).sin());
    recording.extra.insert("band_n".into(), inside.collect());
    let found = answer(&recording, &[]);
    let follows = found.missing.iter().find(|m| m.says.contains("follows band_n")).expect("it follows");
    assert!(follows.indistinguishable_from.contains(&"presliding".to_string()), "{follows:?}");
    assert!(follows.says.contains("presliding"), "{}", follows.says);
}

#[test]
fn a_recording_that_cannot_judge_was_left_out_without_a_word() {
    let (train, _) = record(&Case::default());
    let (mut rest, _) = record(&Case { seed: 2, ..Case::default() });
    rest.name = "rest.csv".into();
    // it moves for 0.2 s and then stands still
    let at = rest.position[200];
    rest.position[200..].fill(at);
    let found = answer(&train, &[rest]);
    assert!(found.validation.is_empty());
    let why = found.recording_faults.iter().map(|f| f.why.as_str()).find(|w| w.contains("cannot judge"));
    assert!(why.is_some_and(|w| w.starts_with("rest.csv")), "{:?}", found.recording_faults);
}
