//! One preparation: an identification and a diagnosis of a file name the same faults, lag, scale, noise, quantum and cut-offs,
//! before either has fitted anything.

#[macro_use]
extern crate untested; // `println!` is shown only when a test fails, or with --nocapture

mod plant;

use diagnose::{Options, diagnose, effect_ids};
use identify::Preprocess;
use plant::{Case, Hidden, Motion, record};
use rayon::prelude::*;
use signals::{FaultKind, Map, Preparation, ReadOptions, Recording};
use std::process::ExitCode;
use untested::{Need, recordings};

const SERVO: &str = "time_s=timestamp,position_rad=position,\
    torque_nm=vin*torque_enable*max(-0.97,min(0.97,0.166*kp*(goal_position-position)))";
const XL330: &str = "time_s=timestamp,position_rad=position,\
    torque_nm=0.13019*vin*torque_enable*max(-1,min(1,0.0028775*kp*(goal_position-position)))";
const SEAL: &str = "time_s=c1/1000,position_m=c5/1000,force_n=c7-50*c6,normal_force_n=50*c6";

/// Folders of the shared data, and what their columns are.
const FOLDERS: [(&str, &str); 14] = [
    ("emps", "time_s=t,position_m=qm,force_n=gtau*vir,reference_m=qg"),
    ("friction_damper", ""),
    ("hsm150", ""),
    ("iiwa_joints", ""),
    ("laas_cogging", "time_s=time_s,position_rad=position_rad,torque_nm=iq_a"),
    ("mtm_joints", ""),
    ("panda_joints", ""),
    ("pneumatic_seal", SEAL),
    ("rack_pinion", ""),
    ("rock_steps", ""),
    ("servo_pendulum", SERVO),
    ("silverbox", "time_s=index/610.35,position_m=V2,force_n=V1"),
    ("virtual", ""),
    ("xl330_pendulum", XL330),
];

static MACHINES: Need = Need::new(|| FOLDERS.iter().find_map(|(folder, _)| recordings(folder).err()));

fn main() -> ExitCode {
    untested::run!(
        tests![identification_and_diagnosis_see_one_recording],
        tests![identification_and_diagnosis_see_one_real_machine].needing(&MACHINES),
    )
}

/// What both say of a recording, and how often that can be compared: an identification refuses what has no clean stretch.
fn agree(recording: &Recording) -> bool {
    // what is looked for later makes no difference to the preparation
    let exclude = effect_ids().into_iter().map(String::from).collect();
    let options = Options { exclude, max_terms: 1, beam_width: 1, ..Options::default() };
    let diagnosed = diagnose(std::slice::from_ref(recording), &[], &options, &|_, _| ()).unwrap();
    let [of_diagnosis] = &diagnosed.preparation[..] else { panic!("{}: one preparation", recording.name) };
    let Ok(signals) = identify::prepare(recording, &Preprocess::default()) else { return false };
    // both name both cut-offs; each uses its own
    let of_fit = signals.preparation();
    let cutoffs = of_fit.cutoffs_hz.expect("a stretch");
    assert_eq!(of_fit.cutoff_hz, Some(cutoffs.fit), "{}", recording.name);
    let cutoff_hz = of_diagnosis.cutoff_hz;
    // a search raises it where it would leave too few rows
    assert!(cutoff_hz >= Some(cutoffs.search), "{}", recording.name);
    assert_eq!(Preparation { cutoff_hz, ..of_fit.clone() }, *of_diagnosis, "{}", recording.name);
    for fault in &of_diagnosis.faults {
        assert!(diagnosed.recording_faults.contains(fault), "{}: {fault:?}", recording.name);
    }
    let quick = diagnosed.recording_faults.iter().any(|f| f.kind == FaultKind::QuickReversals);
    if diagnosed.cutoff_hz.is_finite() && !quick {
        assert_eq!(Some(diagnosed.cutoff_hz), cutoff_hz, "{}", recording.name);
    }
    true
}

fn identification_and_diagnosis_see_one_recording() {
    let mut cases = Vec::new();
    for (seed, motion) in
        [Motion::Multisine, Motion::Sine, Motion::Triangle, Motion::Chirp].into_iter().enumerate()
    {
        for accelerometer in [None, Some(0.3)] {
            let seed = seed as u64;
            let hidden = [Hidden::Stribeck { size: 0.5, speed: 0.02 }, Hidden::Nothing];
            let mut r =
                record(&Case { motion, accelerometer, seed, hidden, seconds: 8.0, ..Case::default() }).0;
            match seed {
                // late, lost, scaled, an outlier
                0 => r.velocity = r.velocity.map(|v| friction::effects::delayed(&v, 1e-3, 1e-3)),
                1 => r.time[3000..].iter_mut().for_each(|t| *t += 0.2),
                2 => r.acceleration.iter_mut().flatten().for_each(|a| *a = 1.2 * *a + 0.5),
                _ => r.force[2000] += 500.0,
            }
            cases.push(r);
        }
    }
    assert_eq!(cases.par_iter().filter(|r| agree(r)).count(), 8);
}

fn identification_and_diagnosis_see_one_real_machine() {
    let mut files = Vec::new();
    for (folder, map) in FOLDERS {
        let list = std::fs::read_dir(recordings(folder).expect("a folder")).expect("a listing");
        files.extend(list.filter_map(|e| Some((e.ok()?.path(), map))));
    }
    let compared = files.par_iter().filter(|(path, map)| {
        let map = (!map.is_empty()).then(|| map.parse::<Map>().expect("a map"));
        agree(&Recording::read(path, &ReadOptions { map, ..ReadOptions::default() }).expect("a recording"))
    });
    let (compared, files) = (compared.count(), files.len());
    println!("{compared} of {files} files compared");
    assert!(compared * 10 >= files * 9);
}
