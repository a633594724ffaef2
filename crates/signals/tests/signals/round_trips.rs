//! Every kind of file gives back what was written; damaged files are refused.

use crate::recordings::{any_recording, cases, same};
use proptest::prelude::*;
use signals::{Geometry, ReadOptions, Recording, WRITTEN};
use std::path::Path;

fn back(recording: &Recording, dir: &Path, suffix: &str) -> Recording {
    let path = dir.join(format!("rec.{suffix}"));
    let remark = recording.write(&path).unwrap();
    let mut back = Recording::read(&path, &ReadOptions::default()).unwrap();
    let infinite = |r: &Recording| r.columns().iter().any(|(_, c)| c.iter().any(|x| x.is_infinite()));
    assert_eq!(remark.is_some(), suffix == "mcap" && infinite(recording), "{remark:?}");
    back.name.clone_from(&recording.name);
    back
}

/// What MCAP can hold: a clock of its own range, and no infinities.
fn for_mcap(mut recording: Recording) -> Recording {
    for (i, t) in recording.time.iter_mut().enumerate() {
        *t = i as f64 * 1e-3 + (*t).clamp(-1.0, 1.0).abs() * 1e-4;
        if !t.is_finite() {
            *t = i as f64;
        }
    }
    let finite =
        |column: &mut Vec<f64>| column.iter_mut().filter(|x| x.is_infinite()).for_each(|x| *x = f64::NAN);
    finite(&mut recording.position);
    finite(&mut recording.force);
    let optional = [
        &mut recording.velocity,
        &mut recording.acceleration,
        &mut recording.normal_force,
        &mut recording.command,
        &mut recording.reference,
        &mut recording.temperature,
    ];
    optional.into_iter().flatten().chain(recording.extra.values_mut()).for_each(finite);
    // a column without a single number is not there
    recording
}

fn with_extra() -> impl Strategy<Value = Recording> {
    (any_recording(), prop::collection::btree_map("[a-zA-Z_./ é]{1,70}[0-9]", any::<f64>(), 0..3)).prop_map(
        |(mut recording, extra)| {
            let n = recording.len();
            recording.extra = extra.into_iter().map(|(name, x)| (name, vec![x; n])).collect();
            recording
        },
    )
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn every_kind_gives_back_what_was_written(recording in with_extra()) {
        let dir = tempfile::tempdir().unwrap();
        for suffix in WRITTEN {
            let written = match suffix {
                "mcap" => for_mcap(recording.clone()),
                // text: names are trimmed by their reader
                "csv" => Recording { extra: Default::default(), ..recording.clone() },
                _ => recording.clone(),
            };
            let read = back(&written, dir.path(), suffix);
            prop_assert!(same(&written, &read), "{}: {:?} became {:?}", suffix, written, read);
        }
    }

    #[test]
    fn a_chain_of_all_kinds_changes_nothing(recording in any_recording()) {
        let dir = tempfile::tempdir().unwrap();
        let first = for_mcap(recording);
        let mut last = first.clone();
        for suffix in WRITTEN.iter().chain(WRITTEN.iter().rev()) {
            last = back(&last, dir.path(), suffix);
        }
        prop_assert!(same(&first, &last), "{:?} became {:?}", first, last);
    }
}

#[test]
fn what_is_lost_is_said() {
    let dir = tempfile::tempdir().unwrap();
    let recording = Recording {
        time: vec![0.0, 0.001],
        position: vec![0.0, f64::INFINITY],
        force: vec![1.0, 2.0],
        geometry: Geometry::Rotary,
        ..Recording::default()
    };
    let remark = recording.write(dir.path().join("a.mcap")).unwrap().unwrap();
    assert_eq!(remark, "1 infinite values are left out: JSON has none");
    let late = Recording { time: vec![0.0, 1e12], ..recording.clone() };
    let said = late.write(dir.path().join("a.mcap")).unwrap_err().to_string();
    assert!(said.contains("sample 1 has time 1000000000000 s, which MCAP cannot hold"), "{said}");
    let said = recording.write(dir.path().join("a.xlsx")).unwrap_err().to_string();
    assert!(
        said.contains(
            "cannot write `.xlsx`; accepted is a name ending in .csv, .mat, .mcap, .parquet or .h5"
        ),
        "{said}"
    );
}
