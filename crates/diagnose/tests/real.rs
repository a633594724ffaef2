//! Recordings of real machines, each with physics that is known from how it was built.
//! `cargo test -p diagnose --test real -- --nocapture` prints what is found and how it does on what was not fitted.

#[macro_use]
extern crate untested; // `println!` is shown only when a test fails, or with --nocapture

use diagnose::{Diagnosis, Options, Verdict, diagnose};
use signals::{FaultKind, Map, ReadOptions, Recording};
use std::path::PathBuf;
use std::process::ExitCode;
use untested::{Need, recordings};

static SILVERBOX: Need = Need::new(|| recordings("silverbox/SNLS80mV.mat").err());
static SERVO_PENDULUM: Need = Need::new(|| recordings("servo_pendulum").err());
static SEAL: Need = Need::new(|| recordings("pneumatic_seal").err());

static MACHINES: Need = Need::new(|| {
    let folders = ["iiwa_joints", "mtm_joints", "friction_damper", "hsm150", "rack_pinion", "rock_steps"];
    folders.iter().find_map(|folder| recordings(folder).err())
});

static ARMS: Need =
    Need::new(|| ["mtm_joints", "panda_joints"].iter().find_map(|folder| recordings(folder).err()));

static MOTOR: Need = Need::new(|| recordings("laas_cogging").err());
static LIFTING: Need =
    Need::new(|| ["iiwa_joints", "xl330_pendulum"].iter().find_map(|folder| recordings(folder).err()));

static PAIRS: Need = Need::new(|| {
    let folders =
        ["iiwa_joints", "hsm150", "mtm_joints", "friction_damper", "pneumatic_seal", "servo_pendulum"];
    folders.iter().chain(&["xl330_pendulum"]).find_map(|folder| recordings(folder).err())
});

fn main() -> ExitCode {
    untested::run!(
        tests![silverbox_is_a_nonlinear_spring_without_dry_friction].needing(&SILVERBOX),
        tests![a_servo_with_a_pendulum_lifts_it_against_gravity].needing(&SERVO_PENDULUM),
        tests![
            a_pneumatic_seal_rubs_harder_under_pressure,
            two_curves_of_which_neither_alone_made_the_next_record_worse_stayed,
        ]
        .needing(&SEAL),
        tests![a_frozen_model_is_no_worse_than_the_baseline_on_the_next_record].needing(&MACHINES),
        tests![motion_in_one_direction_is_a_recording].needing(&MACHINES),
        tests![a_joint_that_is_coupled_to_others_has_no_ripple].needing(&ARMS),
        tests![a_damper_with_play_has_lost_motion].needing(&MACHINES),
        tests![
            a_motor_that_was_held_at_each_angle_has_its_cogging,
            a_motor_that_coasts_shows_what_repeats_in_its_turn,
        ]
        .needing(&MOTOR),
        tests![a_joint_that_lifts_itself_and_a_servo_that_lifts_a_weight_have_gravity].needing(&LIFTING),
        tests![over_all_pairs_of_records_no_frozen_model_is_worse]
            .needing(&PAIRS)
            .on_demand("117 diagnoses, some ten minutes"),
    )
}

/// Files of a folder of recordings whose name contains `part`.
fn files(folder: &str, part: &str) -> Vec<PathBuf> {
    let list = std::fs::read_dir(recordings(folder).expect("a folder")).expect("a listing");
    let mut out: Vec<PathBuf> = list
        .filter_map(|e| Some(e.ok()?.path()))
        .filter(|p| p.file_name().is_some_and(|n| n.to_string_lossy().contains(part)))
        .collect();
    out.sort();
    out
}

fn read(path: &PathBuf, map: &str) -> Recording {
    let map: Option<Map> = (!map.is_empty()).then(|| map.parse().expect("a map"));
    Recording::read(path, &ReadOptions { map, ..ReadOptions::default() }).expect("a recording")
}

fn part(r: &Recording, from: usize, to: usize) -> Recording {
    let cut = |c: &[f64]| c[from..to].to_vec();
    Recording {
        name: format!("{} {from}..{to}", r.name),
        time: cut(&r.time),
        position: cut(&r.position),
        force: cut(&r.force),
        normal_force: r.normal_force.as_deref().map(cut),
        ..r.clone()
    }
}

fn found(train: &[Recording], judge: &[Recording]) -> Diagnosis {
    let began = std::time::Instant::now();
    let found = diagnose(train, judge, &Options::default(), &|_, _| ()).expect("a diagnosis");
    let unit = &found.noise_floor.unit;
    println!("{}\n  {:.1} s, filter {:.1} Hz", found.summary, began.elapsed().as_secs_f64(), found.cutoff_hz);
    for (name, q) in &found.after.parameters {
        println!("  {name} {:.4} ± {:.4} {}", q.value, q.std, q.unit);
    }
    for fault in &found.recording_faults {
        println!("  fault {:?}: {}", fault.kind, fault.why);
    }
    for m in &found.missing {
        println!(
            "  {}: held-out {:.4} -> {:.4} {unit}, gain {:.4} … {:.4}, rivals {:?}, {:?}",
            m.effect,
            m.rms_heldout_before,
            m.rms_heldout_after,
            m.gain_ci95[0],
            m.gain_ci95[1],
            m.indistinguishable_from,
            m.parameters
                .iter()
                .map(|(n, q)| format!("{n} {:.4} ± {:.4}", q.value, q.std))
                .collect::<Vec<_>>()
        );
    }
    println!(
        "  blocks held out: {:.4} -> {:.4} {unit}, floor {:.4}",
        found.baseline.rms_heldout, found.after.rms_heldout, found.noise_floor.rms
    );
    for v in &found.validation {
        println!(
            "  {} not fitted: {:.2} % -> {:.2} % of the force",
            v.recording,
            100.0 * v.relative_before,
            100.0 * v.relative_after
        );
    }
    found
}

fn names(found: &Diagnosis, effect: &str) -> bool {
    found.missing.iter().any(|m| m.effect == effect)
}

/// Effects that are dry friction.
const DRY: [&str; 8] = [
    "stribeck",
    "sublinear_viscous",
    "presliding",
    "frictional_lag",
    "rising_static_friction",
    "position_dependent_friction",
    "load_dependent_friction",
    "periodic_friction",
];

fn silverbox_is_a_nonlinear_spring_without_dry_friction() {
    let files = files("silverbox", "SNLS80mV.mat");
    let all = read(&files[0], "time_s=index/610.35,position_m=V2,force_n=V1");
    // The end of the growing noise, where the spring's stiffening is more than a hundredth of what is left out; two of
    // the ten multisines and what came before judge.
    let train = part(&all, 28_000, 39_500);
    let judge = [part(&all, 41_000, 58_000), part(&all, 110_000, 118_000), part(&all, 10_000, 28_000)];
    let found = found(&[train], &judge);
    assert_eq!(found.verdict, Verdict::Mismatch);
    assert!(names(&found, "nonlinear_spring"), "the cubic spring");
    let dry: Vec<&str> =
        found.missing.iter().map(|m| m.effect.as_str()).filter(|e| DRY.contains(e)).collect();
    assert!(dry.is_empty(), "there is no dry friction: {dry:?}");
    // equal and opposite levels are the offset of the input; their mean is dry friction
    let level = |name: &str| &found.after.parameters[name];
    let (p, n) = (level("coulomb_p"), level("coulomb_n"));
    let dry = 0.5 * (p.value + n.value);
    println!(
        "  dry friction {dry:.5} ± {:.5} V, offset {:.5} V",
        0.5 * p.std.hypot(n.std),
        0.5 * (p.value - n.value)
    );
    assert!(dry.abs() < 0.03 * found.baseline.rms_heldout.max(10.0 * p.std.hypot(n.std)));
    assert!(found.validation.iter().all(|v| v.relative_after < 0.5 * v.relative_before));
}

/// The same of the smaller servo, in newton metres.
const SMALL_SERVO: &str = "time_s=timestamp,position_rad=position,\
    torque_nm=0.13019*vin*torque_enable*max(-1,min(1,0.0028775*kp*(goal_position-position)))";

/// ms, …, laser mm, pressure bar, force N. The pressure pushes the rod with 50 N/bar, the mean of force over pressure in each
/// of the files, and presses the lips on the wall in proportion.
const PRESSED: &str = "time_s=c1/1000,position_m=c5/1000,force_n=c7-50*c6,normal_force_n=50*c6";

/// Rhoban's servo model: duty = 0.166·kp·(goal − position), at most 0.97, of the supply; as a force in volts.
const SERVO: &str = "time_s=timestamp,position_rad=position,\
    torque_nm=vin*torque_enable*max(-0.97,min(0.97,0.166*kp*(goal_position-position)))";

fn a_servo_with_a_pendulum_lifts_it_against_gravity() {
    let files = files("servo_pendulum", ".json");
    let all: Vec<Recording> = files.iter().map(|f| read(f, SERVO)).collect();
    assert_eq!(all.len(), 4);
    // With the torque off the winding is open: without its back-EMF it is another machine.
    let powered = |r: Recording| {
        let off = r.time.iter().position(|t| *t > 1.9).filter(|_| r.name.contains("lift_and_drop"));
        part(&r, 0, off.unwrap_or(r.len()))
    };
    let all = all.into_iter().map(powered);
    let (judge, train): (Vec<Recording>, Vec<Recording>) =
        all.partition(|r| r.name.contains("lift_and_drop") || r.name.contains("square"));
    let found = found(&train, &judge);
    assert_eq!(found.verdict, Verdict::Mismatch);
    assert!(names(&found, "gravity"));
    // tested: named, or with the bound below which it would not have been seen, or what hides it
    let load = "load_dependent_friction";
    let bound = found.rejected.iter().find(|r| r.effect == load);
    let blind = found.blind_to.iter().find(|b| b.effect == load);
    println!("  load dependence: named {}, bound {bound:?}, blind {blind:?}", names(&found, load));
    assert!(names(&found, load) || bound.is_some() || blind.is_some());
    assert!(found.validation.iter().all(|v| v.relative_after < v.relative_before));
}

fn a_pneumatic_seal_rubs_harder_under_pressure() {
    let files = files("pneumatic_seal", "Circle_");
    let all: Vec<Recording> = files.iter().map(|f| read(f, PRESSED)).collect();
    let (judge, train): (Vec<Recording>, Vec<Recording>) =
        all.into_iter().partition(|r| r.name.contains("5bar"));
    let found = found(&train, &judge);
    assert!(found.recording_faults.iter().any(|f| f.kind == FaultKind::LostSamples));
    assert!(names(&found, "load_dependent_friction"));
    let v = &found.validation[0];
    assert!(v.relative_after < v.relative_before);
}

fn two_curves_of_which_neither_alone_made_the_next_record_worse_stayed() {
    let at = |bar: &str| files("pneumatic_seal", bar).iter().map(|f| read(f, PRESSED)).collect::<Vec<_>>();
    let found = found(&at("Circle_3bar"), &at("Circle_1bar"));
    let v = &found.validation[0];
    assert!(v.rms_after <= 1.0001 * v.rms_before, "{} -> {}", v.rms_before, v.rms_after);
}

/// A recording whose header is one of tribos's own.
fn given(file: &str) -> Recording {
    read(&recordings(file).expect("a recording"), "")
}

/// A record of a machine, and the next one.
const NEXT: [(&str, &str); 5] = [
    ("iiwa_joints/joint1_vel_p15.csv", "iiwa_joints/joint1_vel_p3.csv"),
    ("hsm150/idf_pos_0.06_1.csv", "hsm150/idf_pos_0.06_2.csv"),
    ("friction_damper/d1_1Hz_22lb.csv", "friction_damper/d1_0.5Hz_25lb.csv"),
    ("mtm_joints/mtm_one_j1.csv", "mtm_joints/mtm_two_j1.csv"),
    ("mtm_joints/mtm_two_j5.csv", "mtm_joints/mtm_one_j5.csv"),
];

fn a_frozen_model_is_no_worse_than_the_baseline_on_the_next_record() {
    for (train, judge) in NEXT {
        let found = found(&[given(train)], &[given(judge)]);
        let v = found.validation.first().expect("a judgement");
        println!("{train} -> {judge}: {:.4} -> {:.4}", v.rms_before, v.rms_after);
        assert!(v.rms_after <= 1.0001 * v.rms_before, "{train}");
    }
}

fn motion_in_one_direction_is_a_recording() {
    for file in ["hsm150/idf_pos_0.06_1.csv", "rack_pinion/run.csv", "rock_steps/sepiolite.csv"] {
        let found = found(&[given(file)], &[]);
        assert_ne!(found.verdict, Verdict::NotTestable, "{file}");
        assert!(!found.after.parameters.contains_key("coulomb_n"), "{file}: it only goes forward");
        let backward = |b: &diagnose::Blind| b.because.contains("backward");
        assert!(
            !found.blind_to.iter().any(backward),
            "{file}: a column that it does not have absorbs an effect"
        );
        // a push and a step of speed happen once: nothing says that they depend on something else
        println!("{file}: {}", found.summary);
        let outside = found.summary.contains("not in the recording");
        assert!(!outside || found.summary.contains("what acts happened once, or"), "{file}");
    }
}

/// The other joints of the arms move, too, and are not in the files.
fn a_joint_that_is_coupled_to_others_has_no_ripple() {
    let all = [files("mtm_joints", ".csv"), files("panda_joints", ".csv")].concat();
    assert_eq!(all.len(), 13);
    for file in all {
        let found = found(&[read(&file, "")], &[]);
        for line in ["cogging", "periodic_friction", "torque_ripple", "encoder_eccentricity"] {
            assert!(!names(&found, line), "{}: {line}", file.display());
        }
    }
}

fn a_damper_with_play_has_lost_motion() {
    for file in files("friction_damper", ".csv") {
        let found = found(&[read(&file, "")], &[]);
        // forces inside the damper are in the file, and follow its friction
        let rival = |m: &diagnose::Missing| m.indistinguishable_from.iter().any(|r| r == "lost_motion");
        assert!(names(&found, "lost_motion") || found.missing.iter().any(rival), "{}", file.display());
    }
}

/// The current that holds it, every 2 mrad. Its motor is not known; 72 periods a turn are what the current shows.
fn a_motor_that_was_held_at_each_angle_has_its_cogging() {
    let held = read(&recordings("laas_cogging/stopped_map.csv").expect("a recording"), "torque_nm=iq_a");
    let found = found(&[held], &[]);
    let cogging = found.missing.iter().find(|m| m.effect == "cogging").expect("cogging");
    let periods = std::f64::consts::TAU / cogging.parameters["wavelength"].value;
    println!("{periods:.2} periods a turn");
    assert!((periods - periods.round()).abs() < 0.1, "a whole number in a turn");
    assert!(found.after.rms_heldout < 0.6 * found.baseline.rms_heldout);
}

/// At 50 rad/s behind a filter that no inertia asked for, its current was *no mismatch*.
fn a_motor_that_coasts_shows_what_repeats_in_its_turn() {
    let coasts = read(&recordings("laas_cogging/rolling1.csv").expect("a recording"), "torque_nm=iq_a");
    let found = found(&[coasts], &[]);
    let line =
        found.missing.iter().find_map(|m| m.parameters.get("wavelength")).expect("a line over the turn");
    let periods = std::f64::consts::TAU / line.value;
    println!("{periods:.3} periods a turn");
    assert!((periods - periods.round()).abs() < 0.01, "a whole number in a turn");
    // six times as many were seen while it was held
    assert!(
        (72.0 / periods - (72.0 / periods).round()).abs() < 0.01,
        "a part of the cogging of the same motor"
    );
    assert!(found.after.rms_heldout < 0.2 * found.baseline.rms_heldout);
}

fn a_joint_that_lifts_itself_and_a_servo_that_lifts_a_weight_have_gravity() {
    let joint = found(&[given("iiwa_joints/J2_chirp.csv")], &[]);
    assert!(names(&joint, "gravity"));
    assert!(joint.after.rms_heldout < 0.2 * joint.baseline.rms_heldout);
    // within half a radian a sine and a straight line are one
    let runs = files("xl330_pendulum", ".json");
    let [first, _, up, _, next, ..] = &runs[..] else { panic!("{} runs", runs.len()) };
    let of = |file: &PathBuf| read(file, SMALL_SERVO);
    let servo = found(&[of(first), of(up)], &[of(next)]);
    let rival = |m: &diagnose::Missing| m.indistinguishable_from.iter().any(|r| r == "gravity");
    assert!(names(&servo, "gravity") || servo.missing.iter().any(rival));
    assert!(servo.validation[0].rms_after < 0.5 * servo.validation[0].rms_before);
}

/// Median of ratios.
fn median(mut ratios: Vec<f64>) -> f64 {
    ratios.sort_by(f64::total_cmp);
    let middle = ratios.len() / 2;
    if ratios.is_empty() {
        return f64::NAN;
    }
    if ratios.len() % 2 == 1 { ratios[middle] } else { 0.5 * (ratios[middle - 1] + ratios[middle]) }
}

/// Each record of a machine fitted alone and judged by each other one. Loads, pressures and speeds differ between them.
fn over_all_pairs_of_records_no_frozen_model_is_worse() {
    let joints = (1..=5).map(|j| (format!("arm, joint {j}"), files("mtm_joints", &format!("_j{j}")), ""));
    let machines = [
        ("robot's joint", files("iiwa_joints", "joint1"), ""),
        ("motor stand", files("hsm150", ""), ""),
        ("friction damper", files("friction_damper", ""), ""),
        ("seal", files("pneumatic_seal", ""), PRESSED),
        ("servo", files("servo_pendulum", ""), SERVO),
        ("small servo", files("xl330_pendulum", ""), SMALL_SERVO),
    ];
    let machines =
        machines.into_iter().map(|(name, files, map)| (name.to_string(), files, map)).chain(joints);
    let mut all = Vec::new();
    for (name, files, map) in machines {
        let records: Vec<Recording> = files.iter().map(|f| read(f, map)).collect();
        let mut ratios = Vec::new();
        let mut asked = 0;
        for (i, train) in records.iter().enumerate() {
            // of the ten of the small servo each is judged by the next
            let judges = (0..records.len())
                .filter(|j| *j != i && (records.len() < 10 || *j == (i + 1) % records.len()));
            for judge in judges.map(|j| &records[j]) {
                asked += 1;
                let (train, judge) = (std::slice::from_ref(train), std::slice::from_ref(judge));
                let found = diagnose(train, judge, &Options::default(), &|_, _| ()).expect("a diagnosis");
                ratios.extend(found.validation.iter().map(|v| v.rms_after / v.rms_before));
            }
        }
        let worst = ratios.iter().copied().fold(0.0, f64::max);
        println!(
            "{name}: {} of {asked} pairs judged, median {:.3}, worst {worst:.3}",
            ratios.len(),
            median(ratios.clone())
        );
        all.extend(ratios);
    }
    let worse = all.iter().filter(|r| **r > 1.0001).count();
    println!("{} pairs: median {:.3}, {worse} worse than the baseline", all.len(), median(all.clone()));
    assert_eq!(worse, 0);
}
