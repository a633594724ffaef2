//! Recordings of machines, read and audited: measured ones, and the simulated ones of the repository that stand in for them.

#[macro_use]
extern crate untested; // `println!` is shown only when a test fails, or with --nocapture

use signals::{FaultKind, Map, ReadOptions, Recording, audit};
use std::path::Path;
use std::process::ExitCode;
use untested::{Need, recordings};

const EMPS: &str = "emps/DATA_EMPS.mat";
const EMPS_MAP: &str = "time_s=t,position_m=qm,force_n=gtau*vir,reference_m=qg";
/// A second record of the same machine, which judges what is found on the first.
const PULSES: &str = "emps/DATA_EMPS_PULSES.mat";
const SILVERBOX: &str = "silverbox/SNLS80mV.mat";
const SILVERBOX_MAP: &str = "time_s=index/610.35,position_m=V2,force_n=V1";

static HAVE_EMPS: Need = Need::new(|| recordings(EMPS).err());
static HAVE_PULSES: Need = Need::new(|| recordings(PULSES).err()).spared_in_ci();
static HAVE_SILVERBOX: Need = Need::new(|| recordings(SILVERBOX).err());
static HAVE_MTM: Need = Need::new(|| recordings("mtm_joints").err());
static HAVE_MACHINES: Need = Need::new(|| RUN_WELL.iter().find_map(|folder| recordings(folder).err()));
static HAVE_SEAL: Need = Need::new(|| recordings("pneumatic_seal").err());

/// Folders of machines whose encoder and clock lose nothing.
const RUN_WELL: [&str; 4] = ["friction_damper", "hsm150", "iiwa_joints", "rack_pinion"];

fn main() -> ExitCode {
    untested::run!(
        tests![
            simulated_recordings_are_read,
            silent_on_the_positioner,
            silent_on_the_oscillator,
            lost_samples_of_the_positioner_are_placed_though_its_times_are_renumbered,
            lost_samples_of_the_seal_are_counted,
        ],
        tests![silent_on_emps, lost_samples_of_emps_are_placed_though_its_times_are_renumbered]
            .needing(&HAVE_EMPS),
        tests![the_second_record_of_emps_is_read].needing(&HAVE_PULSES),
        tests![silent_on_silverbox].needing(&HAVE_SILVERBOX),
        tests![the_seal_is_read].needing(&HAVE_SEAL),
        tests![a_bus_that_stalls_shows_at_the_same_time_in_several_joints].needing(&HAVE_MTM),
        tests![no_jump_in_machines_that_run_well].needing(&HAVE_MACHINES),
    )
}

fn read(path: &Path, map: &str) -> Recording {
    let map: Map = map.parse().unwrap();
    let r = Recording::read(path, &ReadOptions { map: Some(map), ..ReadOptions::default() }).unwrap();
    let dt = r.sample_period().unwrap();
    println!("{}: {} samples every {dt:.6} s, force {:.4} at first", r.name, r.len(), r.force[0]);
    assert!(r.force.iter().chain(&r.position).all(|x| x.is_finite()));
    r
}

fn measured(file: &str, map: &str) -> Recording {
    read(&recordings(file).unwrap(), map)
}

fn simulated(file: &str, map: &str) -> Recording {
    read(&fixtures::folder().join(file), map)
}

fn positioner() -> Recording {
    simulated("positioner.mat", fixtures::positioner::MAP)
}

fn assert_clean(recording: &Recording) {
    let audit = audit(recording);
    for fault in &audit.faults {
        println!("{:?} at {:?}: {}", fault.kind, fault.at_s, fault.why);
    }
    assert!(audit.is_clean());
}

fn simulated_recordings_are_read() {
    for (file, map, samples) in [
        ("positioner.mat", fixtures::positioner::MAP, 8_000),
        ("oscillator.mat", fixtures::oscillator::MAP, 8_000),
        ("pendulum_slow.json", fixtures::pendulum::MAP, 1_500),
        ("pendulum_fast.json", fixtures::pendulum::MAP, 1_500),
        ("seal_1bar.csv", fixtures::seal::MAP, 1_988),
        ("seal_7bar.csv", fixtures::seal::MAP, 1_988),
    ] {
        assert_eq!(simulated(file, map).len(), samples, "{file}");
    }
}

fn silent_on_the_positioner() {
    assert_clean(&positioner());
}

fn silent_on_the_oscillator() {
    assert_clean(&simulated("oscillator.mat", fixtures::oscillator::MAP));
}

fn silent_on_emps() {
    let recording = measured(EMPS, EMPS_MAP);
    assert_eq!(recording.len(), 24_841);
    assert_clean(&recording);
}

fn silent_on_silverbox() {
    let recording = measured(SILVERBOX, SILVERBOX_MAP);
    assert_eq!(recording.len(), 131_072);
    assert_clean(&recording);
}

fn the_second_record_of_emps_is_read() {
    assert_eq!(measured(PULSES, EMPS_MAP).len(), 24_841);
}

fn the_seal_is_read() {
    for file in ["Circle_1bar.csv", "Kidney_3bar.csv"] {
        let map = "time_s=c1/1000,position_m=c5/1000,force_n=c7";
        assert!(measured(&format!("pneumatic_seal/{file}"), map).len() > 500);
    }
}

/// Takes `lost` samples out at `at` and numbers the times as if nothing were missing.
fn assert_placed(mut recording: Recording, at: usize, lost: usize) {
    let due = recording.time[at];
    let time = recording.time.clone();
    for column in [Some(&mut recording.position), Some(&mut recording.force), recording.reference.as_mut()] {
        column.unwrap().drain(at..at + lost);
    }
    recording.time = time[..recording.position.len()].to_vec();
    let audit = audit(&recording);
    let [fault] = &audit.faults[..] else { panic!("{:?}", audit.faults) };
    println!("{}", fault.why);
    assert_eq!(fault.kind, FaultKind::LostSamples);
    assert!((fault.at_s.unwrap() - due).abs() < 0.002, "{:?}", fault.at_s);
    assert!(fault.why.contains(&format!("{lost} samples")), "{}", fault.why);
}

fn lost_samples_of_emps_are_placed_though_its_times_are_renumbered() {
    assert_placed(measured(EMPS, EMPS_MAP), 5019, 7);
}

fn lost_samples_of_the_positioner_are_placed_though_its_times_are_renumbered() {
    let recording = positioner();
    // where it moves: at rest nothing shows
    let speed = |i: usize| (recording.position[i + 7] - recording.position[i]).abs();
    let fastest = (500..recording.len() - 500).max_by(|a, b| speed(*a).total_cmp(&speed(*b))).unwrap();
    assert_placed(recording, fastest, 7);
}

fn lost_samples_of_the_seal_are_counted() {
    let faults = audit(&simulated("seal_3bar.csv", fixtures::seal::MAP)).faults;
    println!("{faults:?}");
    assert!(faults.iter().all(|f| f.kind == FaultKind::LostSamples && f.why.starts_with("3 samples")));
    let at: Vec<f64> = faults.iter().filter_map(|f| f.at_s).collect();
    assert_eq!(at, [4.47, 8.97, 13.47, 17.97]);
}

/// A recording whose header is one of tribos's own.
fn given(path: &Path) -> Recording {
    Recording::read(path, &ReadOptions::default()).unwrap()
}

fn a_bus_that_stalls_shows_at_the_same_time_in_several_joints() {
    let jump = |f: &&signals::RecordingFault| {
        matches!(f.kind, FaultKind::PositionJump | FaultKind::LostSamples) && f.at_s.is_some()
    };
    let at = [1, 2, 3, 5].map(|joint| {
        let recording = given(&recordings(&format!("mtm_joints/mtm_two_j{joint}.csv")).unwrap());
        audit(&recording).faults.iter().find(jump).and_then(|f| f.at_s)
    });
    assert_eq!(at, [Some(3.44); 4]);
}

fn no_jump_in_machines_that_run_well() {
    for folder in RUN_WELL {
        for file in std::fs::read_dir(recordings(folder).unwrap()).unwrap() {
            let path = file.unwrap().path();
            let faults = audit(&given(&path)).faults;
            assert!(faults.iter().all(|f| f.kind != FaultKind::PositionJump), "{}", path.display());
        }
    }
}
