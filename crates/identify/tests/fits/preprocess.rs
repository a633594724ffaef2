//! Signals made of a recording: every sample in its place, the motion behind the noise, no number that is none.

use identify::{Preprocess, Signals, prepare};
use plant::{ThesisExperiment, materials};
use proptest::prelude::*;
use signals::{Recording, audit};

fn largest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn signals_keep_every_sample_and_rows_skip_gaps() {
    let series = ThesisExperiment::on(&materials::RUBBER).unwrap().recording(1);
    let mut recording = Recording {
        name: "gaps".into(),
        time: series.time,
        position: series.position,
        force: series.force,
        velocity: Some(series.velocity),
        acceleration: Some(series.acceleration),
        ..Recording::default()
    };
    let whole = prepare(&recording, &Preprocess::default()).unwrap();
    println!("{}", whole.description());
    assert_eq!(whole.len(), 2000);
    recording.force[900] = f64::NAN;
    recording.position[901] = f64::NAN;
    recording.time[1500..].iter_mut().for_each(|t| *t += 0.5);
    let broken = prepare(&recording, &Preprocess::default()).unwrap();
    assert_eq!(broken.len(), 2000);
    for column in [&broken.time, &broken.position, &broken.velocity, &broken.acceleration, &broken.force] {
        assert!(column.iter().all(|x| x.is_finite()));
    }
    assert!(broken.recording_faults().len() >= 3);
    // The rows of a constant are the constant; fewer of them, because every stretch loses its edges.
    let rows = |s: &Signals| s.condition(&vec![2.5; s.len()]);
    assert!(rows(&broken).iter().all(|x| (x - 2.5).abs() < 1e-9));
    println!("rows: whole {}, with three stretches {}", rows(&whole).len(), rows(&broken).len());
    assert!(rows(&broken).len() < rows(&whole).len() && rows(&broken).len() > 1000);
    let inner = 200..800;
    assert!(largest(&broken.velocity[inner.clone()], &whole.velocity[inner]) < 0.02);
    let refused =
        prepare(&recording, &Preprocess::Tribos { cutoff_hz: Some(900.0) }).unwrap_err().to_string();
    assert!(refused.contains("cutoff_hz = 900"), "{refused}");
    recording.velocity = None;
    let refused = prepare(&recording, &Preprocess::Thesis).unwrap_err().to_string();
    assert!(refused.contains("velocity_m_s"), "{refused}");
}

#[test]
fn signals_are_the_motion() {
    for material in [&materials::BRASS, &materials::TEFLON, &materials::RUBBER] {
        let experiment = ThesisExperiment::on(material).unwrap();
        let s = experiment.recording(2);
        let mut recording = Recording {
            name: material.name.into(),
            time: s.time,
            position: s.position,
            force: s.force,
            velocity: Some(s.velocity),
            acceleration: Some(s.acceleration),
            ..Recording::default()
        };
        for columns in ["given", "derived"] {
            let signals = prepare(&recording, &Preprocess::default()).unwrap();
            let rms = |a: &[f64], b: &[f64]| {
                (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
            };
            let inner = 100..1900;
            let part = |s: &[f64]| s[inner.clone()].to_vec();
            let v = rms(&part(&signals.velocity), &part(&experiment.truth.velocity));
            let a = rms(&part(&signals.acceleration), &part(&experiment.truth.acceleration));
            println!(
                "{} {columns}: velocity off by {v:.2e} m/s, acceleration by {a:.3} m/s²: {}",
                material.name,
                signals.description()
            );
            assert!(v < 2.5e-3 && a < 0.5);
            recording.velocity = None;
            recording.acceleration = None;
        }
    }
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
