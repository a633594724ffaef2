//! Parameters of simulated machines come back, from recordings that another integrator made: leapfrog steps, forty for each
//! sample, friction as a stopping force.

use benchmark::{
    Between, Drive, Error, Fitted, Found, Place, Plant, Protocol, Record, Stage, State, Way, free_run,
    identified,
};
use friction::effects::EffectKind;
use friction::{Coulomb, CoulombState, FrictionLaw, Motion};
use signals::Recording;

/// A recording of `samples` samples `dt` apart: `force` in time, moved by `step` (x, v, f, h) → v.
fn recorded(
    samples: usize,
    dt: f64,
    substeps: usize,
    held: bool,
    force: impl Fn(f64) -> f64,
    mut step: impl FnMut(f64, f64, f64, f64) -> f64,
) -> Recording {
    let h = dt / substeps as f64;
    let (mut x, mut v) = (0.0, 0.0);
    let mut out = Recording { name: "simulated".into(), ..Recording::default() };
    for i in 0..samples {
        let t = i as f64 * dt;
        out.time.push(t);
        out.position.push(x);
        out.force.push(force(t));
        for k in 0..substeps {
            let acting = if held { force(t) } else { force(t + (k as f64 + 0.5) * h) };
            x += 0.5 * h * v;
            v = step(x, v, acting, h);
            x += 0.5 * h * v;
        }
    }
    out
}

fn assert_recovered(places: &[Place], found: &[f64], truth: &[f64], within: f64) {
    for ((place, value), truth) in places.iter().zip(found).zip(truth) {
        println!("{:34} {value:12.5} truth {truth:12.5}", place.name());
        let off = (value - truth).abs() / truth.abs();
        assert!(off < within, "{}: {value}, {truth} put in", place.name());
    }
}

#[test]
fn friction_of_a_positioner_comes_back() {
    const PLACES: [Place; 6] = [
        Place::Mass,
        Place::Level(Way::Forward),
        Place::Level(Way::Backward),
        Place::Viscous(Way::Forward),
        Place::Viscous(Way::Backward),
        Place::Gain(EffectKind::Spring, 0),
    ];
    let truth = [9.5, 2.1, 2.6, 16.0, 24.0, 30.0];
    let law = Coulomb {
        level_p: truth[1],
        level_n: truth[2],
        static_p: truth[1],
        static_n: truth[2],
        viscous_p: truth[3],
        viscous_n: truth[4],
    };
    let mut state = CoulombState::default();
    let force = |t: f64| 9.0 * (2.3 * t).sin() + 6.0 * (7.1 * t + 0.4).sin() + 3.0 * (19.7 * t).cos();
    let recording = recorded(16_000, 1e-3, 40, true, force, |x, v, f, h| {
        let applied = f - truth[5] * x;
        let motion = Motion { dt: h, position: x, velocity: v, applied, mass: truth[0], ..Motion::default() };
        v + h * (applied - law.step(&mut state, &motion)) / truth[0]
    });
    let record = Record::new("simulated", recording, Between::Held).unwrap();
    let protocol = Protocol { settling: 20, stages: &[Stage::Windows(500), Stage::Windows(4_000)] };
    let found = identified(&PLACES, &record, &(0..12_000), &protocol).unwrap();
    assert_recovered(&PLACES, &found.fitted.values, &truth, 5e-3);
    // what was not fitted, from its first samples to its end
    let error = found.free_run_error(&record, &(12_000..16_000), 20);
    println!("free run: {:.2e} m", error);
    assert!(found.fitted.converged && error < 1e-5);
}

#[test]
fn springs_of_an_oscillator_and_its_delay_come_back() {
    const PLACES: [Place; 6] = [
        Place::Mass,
        Place::Viscous(Way::Both),
        Place::Gain(EffectKind::Spring, 0),
        Place::Gain(EffectKind::NonlinearSpring, 0),
        Place::Gain(EffectKind::NonlinearSpring, 1),
        Place::Delay,
    ];
    let late = 1.5e-4;
    let truth = [5.4e-6, 2.2e-4, 0.99, 4.0, -0.2, late];
    let wave = |t: f64| {
        let lines = (1..=24).map(|k| (52.0 * f64::from(k) * t + f64::from(k * k)).sin());
        0.012 * lines.sum::<f64>()
    };
    let dt = 1.0 / 610.35;
    let mut recording = recorded(6_000, dt, 40, false, wave, |x, v, f, h| {
        // a semi-implicit step, its damping exact
        let spring = x * (truth[2] + x * (truth[4] + x * truth[3]));
        let decay = (-truth[1] * h / truth[0]).exp();
        v * decay + (f - spring) * (1.0 - decay) / truth[1]
    });
    // a channel that is late
    recording.force = recording.time.iter().map(|t| wave(t - late)).collect();
    let record = Record::new("simulated", recording, Between::BandLimited).unwrap();
    let protocol = Protocol { settling: 50, stages: &[Stage::Beginning(1_500), Stage::Whole] };
    let found = identified(&PLACES, &record, &(0..5_000), &protocol).unwrap();
    assert_recovered(&PLACES, &found.fitted.values, &truth, 2e-2);
    assert!(found.fitted.converged);
}

#[test]
fn standard_errors_cover_the_truth() {
    const PLACES: [Place; 3] = [Place::Mass, Place::Level(Way::Both), Place::Viscous(Way::Both)];
    const SAMPLES: usize = 16_000;
    let truth = [2.0, 1.5, 8.0];
    let plant = Plant::new(&PLACES, &truth);
    let (mut beyond, mut outside, mut seed) = (0, 0, 7u64);
    for trial in 0..12 {
        // a force error that wanders, as of a real machine
        let mut noise = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f64 / 2f64.powi(24) - 0.5
        };
        let mut wander = 0.0;
        let shown: Vec<f64> = (0..SAMPLES)
            .map(|i| i as f64 * 1e-3)
            .map(|t| 4.0 * (3.0 * t + f64::from(trial)).sin() + 2.5 * (11.0 * t).sin())
            .collect();
        let acting: Vec<f64> = shown
            .iter()
            .map(|f| {
                wander = 0.98 * wander + 0.1 * noise();
                f + wander
            })
            .collect();
        let drive = Drive::new(&acting, 1e-3, Between::Held);
        let position = free_run(&plant, &drive, 0, SAMPLES, State { position: 0.0, velocity: 0.0 }, 1e3);
        let recording = Recording {
            time: (0..SAMPLES).map(|i| i as f64 * 1e-3).collect(),
            force: shown,
            position,
            ..Recording::default()
        };
        let record = Record::new("simulated", recording, Between::Held).unwrap();
        let protocol = Protocol { settling: 20, stages: &[Stage::Windows(500)] };
        let found = identified(&PLACES, &record, &(0..SAMPLES), &protocol).unwrap();
        for ((value, std), truth) in found.fitted.values.iter().zip(&found.fitted.std).zip(truth) {
            beyond += usize::from((value - truth).abs() > 2.5 * std);
            outside += usize::from((value - truth).abs() > *std);
        }
    }
    println!("{outside} of 36 beyond one standard error, {beyond} beyond 2.5");
    assert!(beyond <= 4 && (4..=20).contains(&outside));
}

#[test]
fn useless_recordings_are_refused_in_one_line() {
    let still = |n: usize| Recording {
        time: (0..n).map(|i| i as f64 * 1e-3).collect(),
        position: vec![0.0; n],
        force: vec![1.0; n],
        ..Recording::default()
    };
    let protocol = Protocol { settling: 20, stages: &[Stage::Whole] };
    let refused = |recording: Recording| -> Error {
        let n = recording.len();
        Record::new("a.mat", recording, Between::Held)
            .and_then(|r| identified(&[Place::Mass, Place::Viscous(Way::Both)], &r, &(0..n), &protocol))
            .unwrap_err()
    };
    for (recording, says) in [
        (still(0), "expected is an even clock"),
        (still(1), "expected is an even clock"),
        (still(5_000), ""),
        (Recording { position: vec![f64::NAN; 100], ..still(100) }, "sample 0 of position_m is NaN"),
        (
            Recording { time: (0..100).map(|i| f64::from(i * i)).collect(), ..still(100) },
            "the clock is uneven",
        ),
    ] {
        let said = refused(recording).to_string();
        println!("{said}");
        assert!(said.contains(says) && !said.contains('\n'), "{said}");
    }
}

#[test]
fn windows_without_samples_have_no_error() {
    let recording = recorded(400, 1e-3, 4, true, |t| (9.0 * t).sin(), |_, v, f, h| v + h * f);
    let record = Record::new("simulated", recording, Between::Held).unwrap();
    let found = Found { places: vec![Place::Mass], fitted: Fitted::given(&[1.0]) };
    for window in [0..0, 0..1, 380..400, 390..900, 900..950, usize::MAX..usize::MAX] {
        let error = found.free_run_error(&record, &window, 20);
        assert!(error.is_nan(), "{window:?} {error}");
    }
    assert!(found.free_run_error(&record, &(0..400), 20) < 1e-6);
}
