//! The audit: silent on good recordings; loud, with the right place and number, on bad ones.

use plant::{Excitation, MeasurementNoise, ThesisExperiment, materials};
use signals::{Audit, FaultKind, Filter, Recording, audit, four_point_difference, zero_phase};
use std::sync::LazyLock;

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

fn only(recording: &Recording, kind: FaultKind) -> signals::RecordingFault {
    let audit = found(recording);
    let kinds: Vec<FaultKind> = audit.faults.iter().map(|f| f.kind).collect();
    assert_eq!(kinds, [kind]);
    audit.faults[0].clone()
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

/// The excitation of [thesis, ch. 3] as an encoder of 2.57 µm counts it.
fn counted() -> Recording {
    let mut recording = of(RUBBER.truth.clone());
    recording.position.iter_mut().for_each(|x| *x = (*x / 2.57e-6).round() * 2.57e-6);
    Recording { velocity: None, acceleration: None, force: thesis(11).force, ..recording }
}

/// They were looked for only where the body keeps its speed.
#[test]
fn samples_lost_while_the_body_accelerates() {
    for (from, count) in [(310, 4), (555, 19), (1203, 9)] {
        let mut recording = counted();
        let time = recording.time.clone();
        for column in columns(&mut recording) {
            column.drain(from..from + count);
        }
        recording.time = time[..recording.position.len()].to_vec();
        let fault = only(&recording, FaultKind::LostSamples);
        assert!((fault.at_s.unwrap() - time[from]).abs() < 1e-9, "{:?}", fault.at_s);
        let said: f64 = fault.why.split("about ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!((said - count as f64).abs() <= 0.1 * count as f64 + 1.0, "{}", fault.why);
        let prepared = signals::prepare(&recording, &signals::Settings::default()).unwrap();
        assert!(prepared.stretches.iter().any(|s| s.range.end == from), "the stretch ends there");
        assert!(prepared.stretches.iter().all(|s| s.range.end <= from || s.range.start >= from));
    }
}

#[test]
fn stamps_of_a_host_are_told_from_samples_at_uneven_times() {
    let late = |i: usize| 0.7e-3 * ((i * 7919 % 1000) as f64 / 1000.0);
    let mut stamped = counted();
    for (i, t) in stamped.time.iter_mut().enumerate() {
        *t += late(i);
    }
    let fault = only(&stamped, FaultKind::IrregularClock);
    assert!(fault.why.contains("a host stamped them"), "{}", fault.why);
    let prepared = signals::prepare(&stamped, &signals::Settings::default()).unwrap();
    assert_eq!(prepared.stretches.len(), 1, "a late stamp is no gap");
    let worst = prepared.recording.time.windows(2).map(|w| (w[1] - w[0] - 1e-3).abs()).fold(0.0, f64::max);
    assert!(worst < 2e-6, "{worst}");
    // the same stamps, and the body where it was at them
    let mut uneven = counted();
    let n = uneven.len();
    let clean = uneven.position.clone();
    for i in 0..n - 1 {
        let share = late(i) / 1e-3;
        uneven.time[i] += late(i);
        uneven.position[i] = clean[i] + share * (clean[i + 1] - clean[i]);
    }
    let fault = found(&uneven).faults.into_iter().find(|f| f.kind == FaultKind::IrregularClock).unwrap();
    assert!(!fault.why.contains("host"), "{}", fault.why);
}

#[test]
fn an_encoder_that_loses_counts_jumps_against_the_motion() {
    let mut recording = counted();
    // in the middle of a stroke, against the motion
    let at = 700;
    let back = -1e-3 * (recording.position[at] - recording.position[at - 1]).signum();
    recording.position[at..].iter_mut().for_each(|x| *x += back);
    let fault = only(&recording, FaultKind::PositionJump);
    assert!((fault.at_s.unwrap() - recording.time[at]).abs() < 1e-9);
    let size: f64 = fault.why.split("by ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((size / back - 1.0).abs() < 0.05, "{}", fault.why);
}

#[test]
fn a_coarse_current_has_the_floor_of_its_steps() {
    let mut recording = thesis(5);
    recording.force.iter_mut().for_each(|f| *f = (*f / 1.5).round() * 1.5);
    let fault = only(&recording, FaultKind::Quantisation);
    assert!(fault.why.contains("4.3301e-1"), "{}", fault.why); // 1.5 N/√12
}

#[test]
fn another_unit_is_suggested() {
    let only_position = |seed| Recording { velocity: None, acceleration: None, ..thesis(seed) };
    let asked = |recording: &Recording, what: &str| {
        let audit = found(recording);
        assert!(audit.faults.iter().any(|f| f.why.contains(what)), "{what}: {:?}", audit.faults);
    };
    let scaled = |by: f64, whole: bool| {
        let mut recording = only_position(13);
        let value = |x: f64| if whole { (x * by).round() } else { x * by };
        recording.position.iter_mut().for_each(|x| *x = value(*x));
        recording
    };
    asked(&scaled(1e3, false), "in mm?");
    asked(&scaled(4e5, true), "in counts");
    let mut degrees = Recording { geometry: signals::Geometry::Rotary, ..scaled(1e4, false) };
    asked(&degrees, "in degrees?");
    // with a tachometer its factor says which
    degrees = Recording { geometry: signals::Geometry::Rotary, ..thesis(13) };
    degrees.acceleration = None;
    degrees.position.iter_mut().for_each(|x| *x *= 180.0 / std::f64::consts::PI);
    asked(&degrees, "the position is in degrees");
    let mut rpm = Recording { geometry: signals::Geometry::Rotary, acceleration: None, ..thesis(13) };
    rpm.velocity.as_mut().unwrap().iter_mut().for_each(|v| *v *= 60.0 / std::f64::consts::TAU);
    asked(&rpm, "turns per minute");
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
