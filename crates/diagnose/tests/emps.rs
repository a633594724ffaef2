//! The EMPS benchmark, a real recording: an electro-mechanical positioning system with a ball screw.

#[macro_use]
extern crate untested; // `println!` is shown only when a test fails, or with --nocapture

use diagnose::{Options, Verdict, diagnose};
use friction::effects::EffectState;
use friction::{Law, Motion};
use identify::{KarnoppOptions, Model, Preprocess, identify_karnopp, prepare};
use signals::{Map, ReadOptions, Recording};
use std::process::ExitCode;
use std::time::Instant;
use untested::{Need, recordings};

const FILE: &str = "emps/DATA_EMPS.mat";

static EMPS: Need = Need::new(|| recordings(FILE).err());

fn main() -> ExitCode {
    untested::run!(
        tests![
            emps_mismatch_is_located_and_named_on_blocks_that_were_held_out,
            the_frozen_model_beats_the_published_one_at_times_it_has_not_seen,
            the_frozen_model_beats_five_parameters_at_speeds_it_has_not_seen,
        ]
        .needing(&EMPS)
    )
}

fn emps() -> Recording {
    let map: Map = "time_s=t,position_m=qm,force_n=gtau*vir,reference_m=qg".parse().expect("a map");
    Recording::read(
        recordings(FILE).expect("a path"),
        &ReadOptions { map: Some(map), ..ReadOptions::default() },
    )
    .expect("EMPS")
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

fn emps_mismatch_is_located_and_named_on_blocks_that_were_held_out() {
    let recording = emps();
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

/// ‖e‖/‖F‖ of a frozen model's prediction of `whole`, behind the published filters, over the rows `of` takes.
fn published_error(model: &Model, whole: &Recording, of: impl Fn(f64) -> bool) -> f64 {
    let signals = prepare(whole, &Preprocess::Emps).expect("the published preprocessing");
    let predicted = signals.condition(&model.predict(whole).expect("a prediction"));
    let measured = signals.condition(&whole.force);
    let time = signals.condition(&signals.time);
    let (mut error, mut size) = (0.0, 0.0);
    for ((p, f), t) in predicted.iter().zip(&measured).zip(time) {
        if of(t) {
            error += (f - p).powi(2);
            size += f * f;
        }
    }
    f64::sqrt(error / size)
}

fn fitted(recording: &Recording) -> (Model, Vec<String>) {
    let found =
        diagnose(std::slice::from_ref(recording), &[], &Options::default(), &|_, _| ()).expect("a diagnosis");
    let model = found.model.expect("a model");
    // as a user gets it: written to a file and read again
    let model = Model::from_toml("model.toml", &model.to_toml()).expect("a model that reads back");
    (model, found.missing.iter().map(|m| m.effect.clone()).collect())
}

/// The recording with the samples that `hide` takes gone.
fn without(recording: &Recording, hide: impl Fn(usize) -> bool) -> Recording {
    let mut out = recording.clone();
    for i in (0..out.len()).filter(|i| hide(*i)) {
        out.position[i] = f64::NAN;
    }
    out
}

/// Which of the three speeds of the reference each sample belongs to: the moves of 0.042, 0.083 and 0.125 m/s, from
/// the reference's stop before to the one after.
fn speeds(recording: &Recording) -> Vec<usize> {
    let reference = recording.reference.as_ref().expect("the reference");
    let n = reference.len();
    let speed: Vec<f64> = (0..n)
        .map(|i| (reference[(i + 1).min(n - 1)] - reference[i.saturating_sub(1)]).abs() / 2e-3)
        .collect();
    let mut out = vec![0; n];
    let mut start = 0;
    for i in 1..=n {
        if i == n || (speed[i] < 0.004 && speed[i] <= speed[i - 1] && i > start + 100) {
            let top = speed[start..i].iter().fold(0.0f64, |m, v| m.max(*v));
            out[start..i].fill(((top / 0.0415).round() as usize).clamp(1, 3));
            start = i;
        }
    }
    out
}

/// Closed loop as on the machine: the model behind the known PD controller follows the reference; the error of the
/// simulated force relative to the measured, over all samples. Sensors and drive are taken for perfect but for the
/// delay.
fn closed_loop(model: &Model, recording: &Recording) -> (f64, f64) {
    // 1/s, V/(m/s), N/V; with the data
    let (kp, kv, gain) = (160.18, 243.45, 35.150_651_88);
    let sub = 20;
    let dt = 1e-3 / f64::from(sub);
    let reference = recording.reference.as_ref().expect("the reference");
    let Law::Karnopp(law) = model.law else { panic!("{:?}", model.law) };
    let mut states = vec![EffectState::<f64>::default(); model.effects.len()];
    let at = |i: usize| (recording.position[i + 1] - recording.position[i]) / 1e-3;
    let (mut x, mut v) = (recording.position[0], at(0));
    // the drive's delay; a force channel that is behind the position by it is ahead of what acts
    let late = ((-model.nuisances.delay_s).max(0.0) / dt).round() as usize;
    let mut pipe: std::collections::VecDeque<f64> = vec![recording.force[0]; late].into();
    let (mut force_error, mut force, mut way_error) = (0.0, 0.0, 0.0);
    for (i, target) in reference.iter().enumerate() {
        let command = gain * kv * (kp * (target - x) - v);
        force_error += (command - recording.force[i]).powi(2);
        force += recording.force[i].powi(2);
        way_error += (x - recording.position[i]).powi(2);
        for _ in 0..sub {
            pipe.push_back(command);
            let applied = pipe.pop_front().unwrap_or(command) - model.nuisances.offset;
            let motion = Motion {
                dt,
                position: x,
                displacement: v * dt,
                velocity: v,
                applied,
                mass: 0.0,
                normal: None,
            };
            let extra: f64 = model.effects.iter().zip(&mut states).map(|(e, s)| e.step(s, &motion)).sum();
            let drag = if v > 0.0 { law.b_p } else { law.b_n } * v;
            let free = v + dt * (applied - drag - extra) / model.mass;
            let level = if free > 0.0 { law.c_p } else { law.c_n };
            // Coulomb friction as a stopping force, less than the level inside the band of rest
            let level = if law.delta_v > 0.0 { level * (free.abs() / law.delta_v).min(1.0) } else { level };
            let stop = dt * level / model.mass;
            v = if free.abs() <= stop { 0.0 } else { free - stop * free.signum() };
            x += dt * v;
        }
    }
    (f64::sqrt(force_error / force), f64::sqrt(way_error / reference.len() as f64))
}

fn plain(recording: &Recording) -> Model {
    let signals = prepare(recording, &Preprocess::default()).expect("signals");
    Model::from(&identify_karnopp(&signals, &KarnoppOptions::default()).expect("five parameters"))
}

fn say(what: &str, before: f64, after: f64) {
    println!("{what:22} {:12.2} % {:18.2} %", 100.0 * before, 100.0 * after);
}

fn the_frozen_model_beats_the_published_one_at_times_it_has_not_seen() {
    let recording = emps();
    let n = recording.len();
    let (model, named) = fitted(&recording);
    println!("{}\nnamed: {named:?}", model.to_toml());
    let five = published_error(&plain(&recording), &recording, |_| true);
    let inside = published_error(&model, &recording, |_| true);
    println!("                       five parameters   with what was left out   (published 3.11 %)");
    say("in sample", five, inside);
    // fitted to one half, frozen, judged by the other
    let (mut of_plain, mut of_model) = (0.0, 0.0);
    for (fitted_to, judge) in [((0, n / 2), (n / 2, n)), ((n / 2, n), (0, n / 2))] {
        let train = part(&recording, fitted_to.0, fitted_to.1);
        let inside = |t: f64| (recording.time[judge.0]..recording.time[judge.1 - 1]).contains(&t);
        of_plain += 0.5 * published_error(&plain(&train), &recording, inside);
        of_model += 0.5 * published_error(&fitted(&train).0, &recording, inside);
    }
    say("blocks (halves)", of_plain, of_model);
    assert!(of_model < 0.6 * of_plain);
    let (before, after) = (closed_loop(&plain(&recording), &recording), closed_loop(&model, &recording));
    println!(
        "closed loop, force     {:12.2} % {:18.2} %   (published 5.85 %); position {:.1e} m and {:.1e} m",
        100.0 * before.0,
        100.0 * after.0,
        before.1,
        after.1
    );
    assert!(inside < 0.5 * five, "equation error {five} -> {inside}");
    assert!(after.0 < before.0 && after.0 < 0.0585);
}

fn the_frozen_model_beats_five_parameters_at_speeds_it_has_not_seen() {
    let recording = emps();
    let speed = speeds(&recording);
    let (mut sum_plain, mut sum_model) = (0.0, 0.0);
    for left_out in 1..=3 {
        let train = without(&recording, |i| speed[i] == left_out);
        let judged = |t: f64| speed[((t / 1e-3).round() as usize).min(recording.len() - 1)] == left_out;
        let (model, named) = fitted(&train);
        let (before, after) = (
            published_error(&plain(&train), &recording, judged),
            published_error(&model, &recording, judged),
        );
        say(&format!("without speed {left_out}"), before, after);
        println!("    {named:?}");
        sum_plain += before * before / 3.0;
        sum_model += after * after / 3.0;
    }
    say("leave one speed out", sum_plain.sqrt(), sum_model.sqrt());
    assert!(sum_model < sum_plain);
}
