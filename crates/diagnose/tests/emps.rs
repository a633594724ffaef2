//! The EMPS benchmark, a real recording: an electro-mechanical positioning system with a ball screw.

use diagnose::{Options, Verdict, diagnose};
use friction::Law;
use identify::{KarnoppOptions, Map, Model, Preprocess, ReadOptions, Recording, identify_karnopp, prepare};
use std::path::Path;
use std::time::Instant;

fn emps() -> Option<Recording> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/emps/DATA_EMPS.mat");
    if !path.exists() {
        assert!(std::env::var_os("CI").is_none(), "{} is needed under CI", path.display());
        eprintln!("skipped: {} is not here", path.display());
        return None;
    }
    let map: Map = "time_s=t,position_m=qm,force_n=gtau*vir,reference_m=qg".parse().expect("a map");
    Some(Recording::read(path, &ReadOptions { map: Some(map) }).expect("EMPS"))
}

fn part(recording: &Recording, from: usize, to: usize) -> Recording {
    Recording {
        time: recording.time[from..to].to_vec(),
        position: recording.position[from..to].to_vec(),
        force: recording.force[from..to].to_vec(),
        reference: recording.reference.as_ref().map(|r| r[from..to].to_vec()),
        ..recording.clone()
    }
}

#[test]
fn emps_mismatch_is_located_and_named_on_blocks_that_were_held_out() {
    let Some(recording) = emps() else { return };
    let begun = Instant::now();
    let found = diagnose(&[recording], &[], &Options::default(), &|_, _| ()).expect("a diagnosis");
    println!("{}\n{:.1} s", found.summary, begun.elapsed().as_secs_f64());
    for l in &found.location {
        println!(
            "  {} {:.4} to {:.4} {}: {:.0} %, p {:.4}",
            l.coordinate,
            l.from,
            l.to,
            l.unit,
            100.0 * l.share_of_mismatch,
            l.p
        );
    }
    for m in &found.missing {
        println!(
            "  {}: {:.3} -> {:.3}, gain {:?}, rivals {:?}",
            m.effect, m.rms_heldout_before, m.rms_heldout_after, m.gain_ci95, m.indistinguishable_from
        );
    }
    println!(
        "  held out {:.3} -> {:.3}, floor {:.3}",
        found.baseline.rms_heldout, found.after.rms_heldout, found.noise_floor.rms
    );
    assert_eq!(found.verdict, Verdict::Mismatch);
    assert!(!found.location.is_empty() && found.location.iter().all(|l| l.p < 0.05));
    assert!(found.missing.iter().any(|m| m.gain_ci95[0] > 0.0));
    assert!(found.after.rms_heldout < 0.8 * found.baseline.rms_heldout);
    assert!(found.missing.windows(2).all(|m| {
        let gain = |m: &diagnose::Missing| m.rms_heldout_before - m.rms_heldout_after;
        gain(&m[0]) >= gain(&m[1])
    }));
}

/// rms of what a model leaves of a recording, behind one and the same filter, N.
fn left(model: &Model, recording: &Recording) -> f64 {
    let model = Model { cutoff_hz: Some(40.0), ..model.clone() };
    let signals = prepare(recording, &Preprocess::Tribos { cutoff_hz: Some(40.0) }).expect("signals");
    let predicted = signals.condition(&model.predict_signals(&signals));
    let measured = signals.condition(&signals.force);
    let squares: f64 = predicted.iter().zip(&measured).map(|(p, m)| (p - m) * (p - m)).sum();
    (squares / measured.len() as f64).sqrt()
}

#[test]
fn the_model_of_one_half_predicts_the_other_better_than_the_published_one() {
    let Some(recording) = emps() else { return };
    let n = recording.len();
    for (fitted, judge) in [((0, n / 2), (n / 2, n)), ((n / 2, n), (0, n / 2))] {
        let train = part(&recording, fitted.0, fitted.1);
        let unseen = part(&recording, judge.0, judge.1);
        let found = diagnose(std::slice::from_ref(&train), &[], &Options::default(), &|_, _| ())
            .expect("a diagnosis");
        let model = found.model.expect("a model");
        model.validate().expect("a model that predicts");
        assert!(matches!(model.law, Law::Karnopp(_)));
        let signals = prepare(&train, &Preprocess::default()).expect("signals");
        let plain =
            Model::from(&identify_karnopp(&signals, &KarnoppOptions::default()).expect("five parameters"));
        let (before, after) = (left(&plain, &unseen), left(&model, &unseen));
        let named: Vec<&str> = found.missing.iter().map(|m| m.effect.as_str()).collect();
        println!("fitted {fitted:?}, unseen {judge:?}: {before:.3} N -> {after:.3} N with {named:?}");
        assert!(after < 0.85 * before, "{before} -> {after}");
    }
}
