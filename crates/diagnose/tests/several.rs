//! Several recordings of one body at once: parameters shared, nuisances per recording only when declared.

mod plant;

use diagnose::{Diagnosis, Error, Nuisance, Options, diagnose};
use plant::{Case, Hidden, Motion, record};
use signals::{Geometry, Recording};
use untested::draws;

fn slide(hidden: Hidden, motion: Motion, seed: u64) -> Recording {
    let case = Case { hidden: [hidden, Hidden::Nothing], motion, seconds: 10.0, seed, ..Case::default() };
    let mut recording = record(&case).0;
    recording.name = format!("{motion:?}-{seed}.csv");
    recording
}

fn run(train: &[Recording], validate: &[Recording], declared: &[Nuisance]) -> Diagnosis {
    let options = Options { per_recording: declared.to_vec(), ..Options::default() };
    let d = diagnose(train, validate, &options, &|_, _| ()).expect("a diagnosis");
    let named: Vec<&str> = d.missing.iter().map(|m| m.effect.as_str()).collect();
    println!("{declared:?}: {named:?}, rms {:.4} → {:.4}", d.baseline.rms_heldout, d.after.rms_heldout);
    for n in &d.nuisances {
        println!("  {} {} {:.5} ± {:.5} {}", n.recording, n.nuisance, n.value, n.std, n.unit);
    }
    for v in &d.validation {
        println!(
            "  {} frozen {:.4} again {:?}: {:?}",
            v.recording, v.rms_after, v.rms_after_refitted, v.nuisances
        );
    }
    d
}

#[test]
fn what_is_declared_to_differ_is_found_and_the_frozen_figure_stands_beside_it() {
    let hidden = Hidden::Cogging { size: 0.25, wavelength: 0.004 };
    for seed in draws(1, 2).map(|draw| 41 + draw) {
        let first = slide(hidden, Motion::Multisine, seed);
        let other = |motion, seed| {
            let mut r = slide(hidden, motion, seed);
            r.force.iter_mut().for_each(|f| *f += 0.2);
            r.position.iter_mut().for_each(|x| *x += 0.0013);
            r
        };
        let train = [first, other(Motion::Chirp, seed + 10)];
        let judge = [other(Motion::Multisine, seed + 20)];
        let shared = run(&train, &judge, &[]);
        let own = run(&train, &judge, &[Nuisance::Offset, Nuisance::Origin]);
        let of = |name: &str| own.nuisances.iter().find(|n| n.nuisance == name).expect("declared");
        assert!((of("offset").value - 0.2).abs() < 4.0 * of("offset").std + 0.005);
        assert!((of("origin").value - 0.0013).abs() < 6e-5, "{:?}", of("origin"));
        assert!(own.after.rms_heldout < 0.8 * shared.after.rms_heldout);
        assert!(own.missing.iter().any(|m| m.effect == "cogging"));
        let v = &own.validation[0];
        let again = v.rms_after_refitted.expect("fitted again");
        assert!(again < 0.7 * v.rms_after, "frozen {} beside {again}", v.rms_after);
        let found = |name: &str| v.nuisances.iter().find(|n| n.nuisance == name).expect("fitted again").value;
        assert!((found("offset") - 0.2).abs() < 0.02 && (found("origin") - 0.0013).abs() < 6e-5);
        // nothing is fitted again that was not declared
        assert!(shared.validation[0].rms_after_refitted.is_none() && shared.nuisances.is_empty());
    }
}

#[test]
fn friction_of_the_day_is_one_number_a_recording() {
    let mut train = vec![slide(Hidden::Spring { size: 0.4 }, Motion::Multisine, 51)];
    for seed in [52, 53] {
        let case = Case {
            coulomb: (1.75 + 0.3, 1.6 + 0.3),
            hidden: [Hidden::Spring { size: 0.4 }, Hidden::Nothing],
            motion: Motion::Chirp,
            seconds: 10.0,
            seed,
            ..Case::default()
        };
        train.push(record(&case).0);
    }
    let d = run(&train, &[], &[Nuisance::Friction]);
    assert!(d.nuisances.len() == 2 && d.nuisances.iter().all(|n| (n.value - 0.3).abs() < 0.03));
    assert!(d.missing.first().is_some_and(|m| m.effect == "spring"));
}

#[test]
fn recordings_that_differ_in_kind_are_refused_by_name_or_fitted_together() {
    let a = slide(Hidden::Nothing, Motion::Multisine, 61);
    let axis = Recording { name: "axis.csv".into(), geometry: Geometry::Rotary, ..a.clone() };
    let loaded = Recording { name: "loaded.csv".into(), normal_force: Some(vec![4.0; a.len()]), ..a.clone() };
    let refused = |other: &Recording| {
        diagnose(&[a.clone(), other.clone()], &[], &Options::default(), &|_, _| ()).unwrap_err()
    };
    println!("{}\n{}", refused(&axis), refused(&loaded));
    assert_eq!(refused(&axis), Error::MixedGeometry { name: "axis.csv".into() });
    assert!(
        matches!(refused(&loaded), Error::MixedNormalForce { name, other } if name == a.name && other == "loaded.csv")
    );
    // another rate, and a velocity channel only one of them has, are no hindrance
    let mut slow = slide(Hidden::Nothing, Motion::Multisine, 62);
    let every = |s: &[f64]| s.iter().step_by(4).copied().collect::<Vec<f64>>();
    (slow.time, slow.position, slow.force) = (every(&slow.time), every(&slow.position), every(&slow.force));
    let mut both = a.clone();
    both.velocity = Some(
        (0..a.len())
            .map(|i| {
                let (low, high) = (i.saturating_sub(2), (i + 2).min(a.len() - 1));
                (a.position[high] - a.position[low]) / (a.time[high] - a.time[low])
            })
            .collect(),
    );
    let d = run(&[both, slow], &[], &[]);
    let mass = &d.baseline.parameters["mass"];
    println!("mass {:.4} ± {:.4}", mass.value, mass.std);
    assert!((mass.value - 0.42).abs() < 0.01);
}

/// An axis of 0.02 kg·m² under 0.5 N·m of friction and a torsion spring of 0.8 N·m/rad, moved in closed form; time is
/// scaled so that the motion suits the rate.
fn axis(rate: f64, seed: u64, columns: bool) -> Recording {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, 0.01).unwrap();
    let lines =
        [(0.5, 1.0, 0.0), (0.25, 2.3, 1.0), (0.15, 4.1, 2.0)].map(|(a, f, p)| (a, f * rate / 800.0, p));
    let mut out =
        Recording { name: format!("axis at {rate} Hz"), geometry: Geometry::Rotary, ..Recording::default() };
    let (mut speeds, mut accelerations) = (Vec::new(), Vec::new());
    for i in 0..12_000 {
        let t = f64::from(i) / rate;
        let (mut x, mut v, mut a) = (0.0, 0.0, 0.0);
        for (reach, f, phase) in lines {
            let (w, at) = (std::f64::consts::TAU * f, std::f64::consts::TAU * f * t + phase);
            x += reach * at.sin();
            v += reach * w * at.cos();
            a -= reach * w * w * at.sin();
        }
        // inertia and drag in the units of the scaled time, so that every rate has the same torques
        let scale = 800.0 / rate;
        out.time.push(t);
        out.position.push(x);
        out.force.push(
            0.004 * scale * scale * a
                + 0.5 * v.signum()
                + 0.02 * scale * v
                + 0.8 * x
                + noise.sample(&mut random),
        );
        speeds.push(v);
        accelerations.push(a);
    }
    if columns {
        (out.velocity, out.acceleration) = (Some(speeds), Some(accelerations));
    }
    out
}

#[test]
fn an_axis_is_diagnosed_at_50_hz_as_at_20_khz_with_columns_and_without() {
    for (rate, columns) in [(50.0, false), (800.0, true), (20_000.0, false), (20_000.0, true)] {
        let d = run(&[axis(rate, 71, columns), axis(rate, 72, columns)], &[], &[]);
        let spring = d.missing.iter().find(|m| m.effect == "spring");
        let stiffness =
            spring.unwrap_or_else(|| panic!("{rate} Hz: {}", d.summary)).parameters["stiffness"].clone();
        println!(
            "{rate} Hz, columns {columns}: {:.4} ± {:.4} {}",
            stiffness.value, stiffness.std, stiffness.unit
        );
        assert!((stiffness.value - 0.8).abs() < 0.02 && stiffness.unit == "N·m/rad", "{stiffness:?}");
    }
}
