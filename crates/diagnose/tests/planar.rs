//! What is concealed in recordings of the rig in the plane. The rig integrates a contact with bristles or with stopping forces;
//! the diagnosis fits an ellipse of constant level.

use diagnose::{Options, Verdict, diagnose_planar};
use friction::planar::{Coulomb, ElastoPlastic, Grain, Law, LuGre, Vector};
use plant_crate::{Path, PlanarConfig, PlanarRig};
use rand::{RngExt, SeedableRng};
use signals::{PlanarRecording, Recording};
use std::f64::consts::{FRAC_PI_2, PI};

/// What is concealed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Concealed {
    Nothing,
    Grain {
        ratio: f64,
        angle: f64,
    },
    /// N·s²/m².
    Drag(f64),
    /// Of the y axis, N/m.
    Spring(f64),
}

impl Concealed {
    fn effect(self) -> Option<&'static str> {
        match self {
            Self::Nothing => None,
            Self::Grain { .. } => Some("anisotropy"),
            Self::Drag(_) => Some("quadratic_drag"),
            Self::Spring(_) => Some("spring"),
        }
    }
}

fn law(level: f64, grain: Grain<f64>, which: u64) -> Law<f64> {
    let contact = friction::LuGre {
        sigma_0: 3e5,
        sigma_1: 50.0,
        sigma_2: 0.0,
        coulomb: level,
        stiction: level,
        stribeck_velocity: 1e-3,
    };
    match which % 4 {
        0 => Law::LuGre(LuGre { contact, grain }),
        1 => Law::ElastoPlastic(ElastoPlastic { contact: friction::ElastoPlastic::of(contact, 0.8), grain }),
        _ => Law::Coulomb(Coulomb { level, stiction: level, viscous: 0.0, grain }),
    }
}

fn path(seed: u64) -> Path {
    // each kind of what is concealed on every path
    match (seed / 6 + seed) % 3 {
        0 => Path::Multisines { amplitude: 0.04, frequency: 0.8 },
        1 => Path::Circles { radius: 0.03, frequency: 1.1 },
        _ => Path::Lines { half: 0.04, frequency: 1.0, lines: 7 },
    }
}

fn recorded(concealed: Concealed, seed: u64) -> PlanarRecording {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let level = 0.6 + 1.5 * random.random::<f64>();
    let grain = match concealed {
        Concealed::Grain { ratio, angle } => Grain::at(angle, ratio),
        _ => Grain::default(),
    };
    // laws that stop a body know one mass
    let heavy = if seed % 4 < 2 { 0.5 } else { 0.4 };
    let config = PlanarConfig {
        mass: Vector { x: 0.4, y: heavy },
        force_zero: Vector { x: 0.05, y: -0.08 },
        ..PlanarConfig::default()
    };
    let mut rig = PlanarRig::new(config, law(level, grain, seed), seed).expect("a rig");
    let viscous = 1.0 + 2.0 * random.random::<f64>();
    let seen = rig.record(&path(seed), 8.0, |_, x, v| {
        let further = match concealed {
            Concealed::Drag(c) => v * (c * v.norm()),
            Concealed::Spring(k) => Vector { x: 0.0, y: k * x.y },
            _ => Vector::default(),
        };
        v * viscous + further
    });
    let [px, py] = seen.position;
    let [fx, fy] = seen.force;
    let axis = |position, force| Recording {
        name: format!("{seed}.csv"),
        time: seen.time.clone(),
        position,
        force,
        ..Recording::default()
    };
    PlanarRecording { name: format!("{seed}.csv"), axes: [axis(px, fx), axis(py, fy)] }
}

/// What was named, and the parameters of the first.
fn named(recording: PlanarRecording) -> diagnose::Diagnosis {
    diagnose_planar(&[recording], &Options::default(), &|_, _| ()).expect("diagnosed").found
}

#[test]
fn what_is_concealed_in_the_plane_is_named() {
    let (mut named_right, mut placed, mut misnamed, mut more, mut cases) = (0, 0, 0, 0, 0);
    for seed in 0..30 {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1000 + seed);
        let concealed = match seed % 6 {
            4 => Concealed::Drag(10.0 + 20.0 * random.random::<f64>()),
            5 => Concealed::Spring(5.0 + 15.0 * random.random::<f64>()),
            _ => Concealed::Grain {
                ratio: 1.05 + 0.95 * random.random::<f64>(),
                angle: PI * random.random::<f64>() - FRAC_PI_2,
            },
        };
        let found = named(recorded(concealed, seed));
        cases += 1;
        let effects: Vec<&str> = found.missing.iter().map(|m| m.effect.as_str()).collect();
        let wanted = concealed.effect().expect("something is concealed");
        let hit = effects.contains(&wanted);
        named_right += usize::from(hit);
        misnamed += usize::from(!hit && !effects.is_empty());
        more += usize::from(hit && effects.len() > 1);
        let mut place = String::new();
        if let (Concealed::Grain { ratio, angle }, Some(m)) =
            (concealed, found.missing.iter().find(|m| m.effect == wanted))
        {
            let (r, a) = (m.parameters["ratio"].value, m.parameters["angle"].value);
            let turned = (a - angle) - PI * ((a - angle) / PI).round();
            let right = (r / ratio - 1.0).abs() < 0.03 && turned.abs() < 0.1;
            placed +=
                usize::from(right && found.location.iter().any(|l| l.coordinate.starts_with("direction")));
            place = format!("ratio {r:.3} of {ratio:.3}, angle off by {turned:.3}");
        }
        println!("{seed}: {concealed:?}: {effects:?} {place}");
    }
    println!(
        "{cases} concealed: {named_right} named, {placed} of 20 grains placed, {misnamed} misnamed, {more} with more beside"
    );
    assert!(named_right >= 28 && misnamed == 0 && placed >= 19 && more <= 3);
}

#[test]
fn nothing_is_named_where_nothing_is_concealed() {
    let mut alarms = 0;
    for seed in 0..20 {
        let found = named(recorded(Concealed::Nothing, 500 + seed));
        let effects: Vec<&str> = found.missing.iter().map(|m| m.effect.as_str()).collect();
        alarms += usize::from(found.verdict != Verdict::NoMismatch);
        println!(
            "{seed}: {:?} {effects:?}, {:.4} N of noise {:.4} N",
            found.verdict, found.baseline.rms_heldout, found.noise_floor.rms
        );
    }
    println!("{alarms} of 20 recordings in which nothing is concealed were given something");
    assert!(alarms <= 2);
}

#[test]
fn a_motion_on_one_line_is_blind_to_the_grain() {
    let law = law(1.0, Grain::at(0.4, 1.8), 0);
    let mut rig = PlanarRig::new(PlanarConfig::default(), law, 1).expect("a rig");
    let line = Path::Lines { half: 0.04, frequency: 1.0, lines: 1 };
    let seen = rig.record(&line, 10.0, |_, _, v| v * 2.0);
    let [px, py] = seen.position;
    let [fx, fy] = seen.force;
    let axis =
        |position, force| Recording { time: seen.time.clone(), position, force, ..Recording::default() };
    let found = named(PlanarRecording { name: "line.csv".into(), axes: [axis(px, fx), axis(py, fy)] });
    println!("{:?}\n{:?}", found.summary, found.blind_to);
    assert!(found.missing.iter().all(|m| m.effect != "anisotropy"));
    assert!(found.blind_to.iter().any(|b| b.effect == "anisotropy"));
}

#[test]
fn options_for_recordings_on_a_line_are_refused() {
    let recording = recorded(Concealed::Nothing, 1);
    let options = Options { absolute: true, ..Options::default() };
    let refused = diagnose_planar(&[recording], &options, &|_, _| ()).expect_err("refused").to_string();
    assert!(refused.contains("absolute") && refused.contains("on a line only"), "{refused}");
}
