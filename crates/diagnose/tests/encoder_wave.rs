//! A wave on the encoder: found where an accelerometer is there to tell it, and not where none is.

mod plant;

use plant::{Case, Hidden, Motion, record};
use rayon::prelude::*;
use signals::{Recording, Settings, Wave, prepare};
use std::f64::consts::TAU;

/// The wave that the preparation takes off.
fn wave(recording: &Recording) -> Option<Wave> {
    prepare(recording, &Settings::default()).unwrap().wave
}

/// The encoder as it would read a body at `x`.
fn read_through(r: &mut Recording, amplitude: f64, wavelength: f64) {
    r.position.iter_mut().for_each(|x| *x += amplitude * (TAU * *x / wavelength + 0.7).cos());
}

const MOTIONS: [Motion; 4] = [Motion::Multisine, Motion::Sine, Motion::Triangle, Motion::Chirp];

#[test]
fn a_wave_is_told_from_an_accelerometer_as_large_as_it_is() {
    let (mut inside, mut total, mut found) = (0, 0, 0);
    for seed in 0..24 {
        let motion = [Motion::Multisine, Motion::Chirp][seed as usize % 2];
        let case = Case { motion, accelerometer: Some(0.03), seed, seconds: 8.0, ..Case::default() };
        let (amplitude, wavelength) =
            ([5e-6, 2e-5, 1e-4][seed as usize % 3], [4e-3, 8e-3, 1.3e-2][seed as usize % 3]);
        let mut r = record(&case).0;
        read_through(&mut r, amplitude, wavelength);
        let Some(wave) = wave(&r) else {
            println!("{seed}: none");
            continue;
        };
        found += 1;
        for ((value, std), truth) in
            [(wave.amplitude, amplitude), (wave.phase, 0.7), (wave.wavelength, wavelength)]
        {
            total += 1;
            inside += usize::from((value - truth).abs() < 1.96 * std);
            println!(
                "{seed}: {value:.4e} ± {std:.1e}, is {truth:.4e}, {:.1} deviations off",
                (value - truth) / std
            );
        }
    }
    println!("{found} of 24; {inside} of {total} inside");
    assert!(found >= 23 && inside * 10 >= total * 8);
}

/// Motions that repeat, an encoder with steps and one without, and accelerometers with everything that is wrong with one.
#[test]
fn what_is_no_wave_is_not_taken_for_one() {
    let alarm = |seed: u64| {
        let pick = |k: u64, of: &[f64]| of[(seed / k) as usize % of.len()];
        let hidden = [
            Hidden::Nothing,
            Hidden::Cogging { size: 0.5, wavelength: 0.004 },
            Hidden::PeriodicFriction { size: 0.5, wavelength: 0.004 },
            Hidden::Bristles { size: 0.6, reach: 3e-4 },
        ][(seed / 4 % 4) as usize];
        let quantum = pick(16, &[2.57e-6, 0.0, 2e-5]);
        let case = Case {
            motion: MOTIONS[(seed % 4) as usize],
            accelerometer: Some(pick(5, &[0.3, 0.03, 0.003])),
            noise_position: pick(3, &[1e-6, 1e-7]),
            hidden: [hidden, Hidden::Nothing],
            quantum,
            seed,
            seconds: 8.0,
            ..Case::default()
        };
        let mut r = record(&case).0;
        let wrong = seed / 7 % 5;
        let mut a = r.acceleration.take().unwrap();
        let n = a.len();
        match wrong {
            1 => a.iter_mut().for_each(|a| *a = 1.15 * *a + 0.4),
            2 => a = friction::effects::delayed(&a, 1.7e-3, 1e-3),
            3 => {
                // its own second-order low-pass at 60 Hz, as it would be built in
                let mut state = [0.0; 2];
                let keep = (-TAU * 60.0 * 1e-3f64).exp();
                for a in &mut a {
                    state[0] = *a + (state[0] - *a) * keep;
                    state[1] = state[0] + (state[1] - state[0]) * keep;
                    *a = state[1];
                }
            }
            4 => a.iter_mut().enumerate().for_each(|(i, a)| *a += 0.5 * (i as f64 / n as f64).powi(2)),
            _ => {}
        }
        r.acceleration = Some(a);
        if let Some(wave) = wave(&r) {
            println!("{seed}: {:?} {hidden:?} wrong {wrong} quantum {quantum:.1e}: {wave:?}", case.motion);
            return true;
        }
        false
    };
    let alarms = (0..160).into_par_iter().filter(|seed| alarm(*seed)).count();
    println!("{alarms} waves in 160 recordings without one");
    assert!(alarms <= 1);
}
