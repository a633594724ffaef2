//! The audit: silent on good recordings, measured and simulated; loud, with the right place and number, on bad ones.

use identify::{
    Audit, FaultKind, Filter, Map, Preprocess, ReadOptions, Recording, audit, four_point_difference, prepare,
    zero_phase,
};
use plant::{Excitation, MeasurementNoise, ThesisExperiment, materials};
use proptest::prelude::*;
use std::path::Path;
use std::sync::LazyLock;

fn measured(file: &str, map: &str) -> Option<Recording> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(file);
    if !path.exists() {
        assert!(std::env::var("CI").as_deref() != Ok("true"), "{} is not there", path.display());
        println!("SKIPPED: {} is not there", path.display());
        return None;
    }
    Some(Recording::read(&path, &ReadOptions { map: Some(map.parse::<Map>().unwrap()) }).unwrap())
}

fn emps() -> Option<Recording> {
    measured("emps/DATA_EMPS.mat", "time_s=t,position_m=qm,force_n=gtau*vir,reference_m=qg")
}

static RUBBER: LazyLock<ThesisExperiment> =
    LazyLock::new(|| ThesisExperiment::on(&materials::RUBBER).unwrap());

fn of(series: plant::Series) -> Recording {
    Recording {
        name: "simulated".into(),
        time: series.time,
        position: series.position,
        velocity: Some(series.velocity),
        acceleration: Some(series.acceleration),
        force: series.force,
        ..Recording::default()
    }
}

fn thesis(seed: u64) -> Recording {
    of(RUBBER.recording(seed))
}

fn found(recording: &Recording) -> Audit {
    let audit = audit(recording);
    for fault in &audit.faults {
        println!("{:?} at {:?}: {}", fault.kind, fault.at_s, fault.why);
    }
    audit
}

fn only(recording: &Recording, kind: FaultKind) -> identify::RecordingFault {
    let audit = found(recording);
    let kinds: Vec<FaultKind> = audit.faults.iter().map(|f| f.kind).collect();
    assert_eq!(kinds, [kind]);
    audit.faults[0].clone()
}

#[test]
fn silent_on_emps() {
    let Some(recording) = emps() else { return };
    assert_eq!(recording.len(), 24_841);
    assert!(found(&recording).is_clean());
}

#[test]
fn silent_on_silverbox() {
    let Some(recording) = measured("silverbox/SNLS80mV.mat", "time_s=index/610.35,position_m=V2,force_n=V1")
    else {
        return;
    };
    assert_eq!(recording.len(), 131_072);
    assert!(found(&recording).is_clean());
}

#[test]
fn silent_on_the_thesis_experiment() {
    for material in [&materials::BRASS, &materials::TEFLON, &materials::RUBBER] {
        let experiment = ThesisExperiment::on(material).unwrap();
        for seed in 0..20 {
            let audit = found(&of(experiment.recording(seed)));
            assert!(audit.is_clean(), "{} seed {seed}", material.name);
        }
        assert!(found(&of(experiment.truth.clone())).is_clean(), "{} without noise", material.name);
    }
}

#[test]
fn silent_on_other_motions_and_noise() {
    let law = materials::BRASS.law;
    for (amplitude, frequency) in [(0.002, 0.5), (0.01, 8.0), (0.005, 15.0)] {
        for scale in [0.0, 0.1, 1.0] {
            let excitation =
                Excitation { amplitude, frequency, seconds: 4.0, warm_up: 1.0, ..Excitation::THESIS };
            let experiment = ThesisExperiment::with(0.4, law, &excitation).unwrap();
            let t = MeasurementNoise::THESIS;
            let noise = MeasurementNoise {
                position: scale * t.position,
                velocity: scale * t.velocity,
                acceleration: scale * t.acceleration,
                force: scale * t.force,
            };
            println!("{amplitude} m, {frequency} Hz, noise × {scale}");
            assert!(found(&of(experiment.recording_with(&noise, 3))).is_clean());
        }
    }
}

#[test]
fn lost_samples_are_placed() {
    let mut recording = thesis(1);
    for column in columns(&mut recording) {
        column.drain(719..724);
    }
    let fault = only(&recording, FaultKind::LostSamples);
    assert!((fault.at_s.unwrap() - 0.719).abs() < 1e-9);
    assert!(fault.why.contains("5 samples"));
}

#[test]
fn lost_samples_are_placed_even_if_the_times_were_numbered_anew() {
    let Some(mut recording) = emps() else { return };
    let time = recording.time.clone();
    for column in columns(&mut recording) {
        column.drain(5019..5026);
    }
    recording.time = time[..recording.position.len()].to_vec();
    let fault = only(&recording, FaultKind::LostSamples);
    assert!((fault.at_s.unwrap() - 5.019).abs() < 0.002, "{:?}", fault.at_s);
    assert!(fault.why.contains("7 samples"), "{}", fault.why);
}

#[test]
fn a_clock_that_jitters_stops_or_goes_back() {
    let mut jittering = thesis(2);
    for (i, t) in jittering.time.iter_mut().enumerate() {
        *t += 2e-4 * ((i * 7919 % 1000) as f64 / 1000.0 - 0.5) * 2.0;
    }
    only(&jittering, FaultKind::IrregularClock);
    let mut back = thesis(2);
    back.time[300] = back.time[298];
    let kinds: Vec<FaultKind> = found(&back).faults.iter().map(|f| f.kind).collect();
    assert!(kinds.contains(&FaultKind::ClockBackward), "{kinds:?}");
    let mut still = thesis(2);
    still.time.fill(1.0);
    only(&still, FaultKind::ClockBackward);
}

#[test]
fn a_wrong_rate_is_told_from_a_wrong_velocity() {
    let mut declared = thesis(3);
    declared.metadata.insert("sample_rate_hz".into(), "500".into());
    only(&declared, FaultKind::TimeBase);
    let mut scaled = thesis(3);
    scaled.velocity.as_mut().unwrap().iter_mut().for_each(|v| *v *= 1.1);
    let fault = only(&scaled, FaultKind::VelocityScale);
    let factor: f64 = fault.why.split_whitespace().nth(2).unwrap().parse().unwrap();
    assert!((factor - 1.1).abs() < 0.01, "{}", fault.why);
    let mut clock = thesis(3);
    clock.time.iter_mut().for_each(|t| *t *= 1.25);
    let fault = only(&clock, FaultKind::TimeBase);
    assert!(fault.why.contains("0.8"), "{}", fault.why);
    let mut other = thesis(3);
    other.velocity = Some(other.position.iter().map(|x| 3.0 * x).collect());
    only(&other, FaultKind::VelocityMismatch);
}

#[test]
fn a_low_pass_before_the_recording_shows() {
    for hz in [25.0, 60.0, 120.0] {
        let mut recording = thesis(4);
        let filter = Filter::butterworth(4, hz, 1e-3).unwrap();
        recording.force = zero_phase(&filter, &recording.force);
        let fault = only(&recording, FaultKind::HiddenFilter);
        let near: f64 = fault.why.split("near ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!(near > 0.6 * hz && near < 1.7 * hz, "{hz} Hz: {}", fault.why);
    }
    // One that delays shows in a velocity column against the position.
    let mut late = thesis(4);
    let velocity = late.velocity.as_mut().unwrap();
    let mut state = velocity[0];
    for v in velocity.iter_mut() {
        state += (*v - state) * 0.1;
        *v = state;
    }
    let fault = only(&late, FaultKind::HiddenFilter);
    let lag: f64 = fault.why.split("is ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((lag - 9.0).abs() < 1.0, "{}", fault.why);
}

#[test]
fn rails_steps_constants_and_rest() {
    let mut clipped = thesis(5);
    clipped.force.iter_mut().for_each(|f| *f = f.clamp(-2.5, 3.0));
    let kinds: Vec<FaultKind> = found(&clipped).faults.iter().map(|f| f.kind).collect();
    assert!(!kinds.is_empty() && kinds.iter().all(|k| *k == FaultKind::Saturation), "{kinds:?}");
    let mut coarse = thesis(5);
    coarse.force.iter_mut().for_each(|f| *f = (*f / 1.5).round() * 1.5);
    only(&coarse, FaultKind::Quantisation);
    let mut constant = thesis(5);
    constant.force.fill(1.0);
    only(&constant, FaultKind::ConstantChannel);
    let mut rest = thesis(5);
    let noise: Vec<f64> = rest.position.iter().zip(&RUBBER.truth.position).map(|(m, t)| m - t).collect();
    rest.position = noise;
    rest.velocity = None;
    rest.acceleration = None;
    only(&rest, FaultKind::TooLittleMotion);
}

#[test]
fn values_that_are_not_numbers_have_a_time() {
    let mut recording = thesis(6);
    recording.force[700] = f64::NAN;
    recording.force[701] = f64::INFINITY;
    let fault = only(&recording, FaultKind::NotANumber);
    assert!((fault.at_s.unwrap() - recording.time[700]).abs() < 1e-9);
    assert!(fault.why.contains("force_n") && fault.why.contains("1 more"));
}

#[test]
fn short_empty_or_broken_recordings_do_not_panic() {
    for n in [0, 1, 2, 5, 63] {
        let mut short = thesis(7);
        for column in columns(&mut short) {
            column.truncate(n);
        }
        assert!(!found(&short).is_clean());
    }
    let mut ragged = thesis(7);
    ragged.force.pop();
    only(&ragged, FaultKind::TooShort);
    let mut nothing = thesis(7);
    for column in columns(&mut nothing) {
        column.fill(f64::NAN);
    }
    assert!(!found(&nothing).is_clean());
}

#[test]
fn faults_serialise_as_promised() {
    let mut recording = thesis(8);
    for column in columns(&mut recording) {
        column.remove(500);
    }
    let json = serde_json::to_value(&audit(&recording).faults).unwrap();
    println!("{json}");
    assert_eq!(json[0]["kind"], "lost_samples");
    assert!((json[0]["at_s"].as_f64().unwrap() - 0.5).abs() < 1e-9);
}

#[test]
fn a_derived_velocity_column_is_accepted() {
    let mut recording = thesis(9);
    let filter = Filter::butterworth(4, 60.0, 1e-3).unwrap();
    recording.velocity = Some(four_point_difference(&zero_phase(&filter, &recording.position), 1e-3));
    assert!(found(&recording).is_clean());
}

fn columns(r: &mut Recording) -> Vec<&mut Vec<f64>> {
    let mut out = vec![&mut r.time, &mut r.position, &mut r.force];
    let optional = [&mut r.velocity, &mut r.acceleration, &mut r.reference];
    out.extend(optional.into_iter().filter_map(Option::as_mut));
    out
}

/// A value as recordings have them, or as they should not have them.
fn value() -> impl Strategy<Value = f64> {
    prop_oneof![6 => -1.0f64..1.0, 1 => prop::num::f64::ANY, 1 => Just(f64::NAN), 1 => Just(0.0), 1 => Just(1e300)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the columns hold: no panic, and every signal that comes out is a number.
    #[test]
    fn anything_is_audited_and_prepared_or_refused(
        columns in prop::collection::vec(prop::collection::vec(value(), 150), 5),
        even: bool,
        holes in prop::collection::vec((0usize..5, 0usize..150), 0..5),
        which in 0usize..4,
    ) {
        let mut columns = columns;
        if even {
            for column in &mut columns {
                column.iter_mut().for_each(|x| *x = if x.is_finite() { x.clamp(-1.0, 1.0) } else { 0.5 });
            }
            columns[0] = (0..150).map(|i| f64::from(i) * 1e-3).collect();
        }
        for (column, at) in holes {
            columns[column][at] = f64::NAN;
        }
        let mut next = columns.into_iter();
        let mut take = || next.next().unwrap();
        let mut recording = Recording {
            time: take(),
            position: take(),
            force: take(),
            velocity: Some(take()),
            acceleration: Some(take()),
            ..Recording::default()
        };
        if which == 3 {
            recording.velocity = None;
        }
        let _ = audit(&recording);
        for how in [Preprocess::default(), Preprocess::Emps, Preprocess::Thesis] {
            if let Ok(signals) = prepare(&recording, &how) {
                for column in [&signals.position, &signals.velocity, &signals.acceleration, &signals.force] {
                    prop_assert_eq!(column.len(), 150);
                    if even {
                        prop_assert!(column.iter().all(|x| x.is_finite()));
                    }
                }
            }
        }
    }
}

/// The published preprocessing by itself: plain least squares on its rows gives the published figures.
#[test]
fn emps_rows_give_the_published_fit() {
    let Some(recording) = emps() else { return };
    let signals = prepare(&recording, &Preprocess::Emps).unwrap();
    let of = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
        signals.condition(&signals.velocity.iter().map(|v| f(*v)).collect::<Vec<_>>())
    };
    let columns = [
        signals.condition(&signals.acceleration),
        of(&|v| v.max(0.0)),
        of(&|v| f64::from(v > 0.0)),
        of(&|v| v.min(0.0)),
        of(&|v| -f64::from(v < 0.0)),
    ];
    let force = nalgebra::DVector::from_vec(signals.condition(&signals.force));
    let x = nalgebra::DMatrix::from_fn(force.len(), 5, |i, k| columns[k][i]);
    let fitted = x.clone().svd(true, true).solve(&force, 1e-12).unwrap();
    let error = (&force - &x * &fitted).norm() / force.norm();
    println!("{} rows, relative error {:.3} %: {:.3?}", force.len(), 100.0 * error, fitted.as_slice());
    assert_eq!(force.len(), 2480);
    assert!((100.0 * error - 3.112).abs() < 0.002);
    for (found, published) in fitted.iter().zip([95.154, 166.71, 20.144, 240.42, 20.628]) {
        assert!((found / published - 1.0).abs() < 2e-4, "{found}, published {published}");
    }
}
