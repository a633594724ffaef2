//! The simulated positioner of the repository: what the tests of EMPS ask, asked of a machine that is known.

use fixtures::positioner::{COGGING, FRICTION, MAP, MASS};
use identify::{DahlOptions, KarnoppOptions, Model, Preprocess, identify_dahl, identify_karnopp, prepare};
use signals::{Map, ReadOptions, Recording};

fn recording() -> Recording {
    let map: Map = MAP.parse().unwrap();
    Recording::read(
        fixtures::folder().join("positioner.mat"),
        &ReadOptions { map: Some(map), ..ReadOptions::default() },
    )
    .unwrap()
}

#[test]
fn parameters_come_back_from_the_file_by_both_preprocessings() {
    let recording = recording();
    for how in [Preprocess::Emps, Preprocess::default()] {
        let signals = prepare(&recording, &how).unwrap();
        let found = identify_karnopp(&signals, &KarnoppOptions::default()).unwrap();
        println!("{}: relative error {:.2} %", found.preprocess, 100.0 * found.relative_error);
        let [[coulomb_p, viscous_p], [coulomb_n, viscous_n]] = FRICTION;
        // the cogging that the law leaves out spreads over the levels and over what the speed multiplies
        let speed = 0.2;
        for (name, truth, allowed) in [
            ("mass", MASS, 0.01 * MASS),
            ("coulomb_p", coulomb_p, 0.5 * COGGING[0]),
            ("coulomb_n", coulomb_n, 0.5 * COGGING[0]),
            ("viscous_p", viscous_p, 0.5 * COGGING[0] / speed),
            ("viscous_n", viscous_n, 0.5 * COGGING[0] / speed),
        ] {
            let p = &found.parameters[name];
            println!("  {name:10} {truth:7.2} {:8.3} ± {:.3}", p.value, p.std);
            assert!((p.value - truth).abs() < allowed && (p.value - truth).abs() < 4.0 * p.std, "{name}");
        }
    }
}

#[test]
fn dahl_does_not_invent_a_stiffness() {
    let signals = prepare(&recording(), &Preprocess::default()).unwrap();
    let found = identify_dahl(&signals, &DahlOptions::default()).unwrap();
    println!("{:?}\n{:?}", found.parameters, found.not_identifiable);
    let said =
        found.not_identifiable.iter().any(|n| n.parameter == "sigma" && n.experiment.starts_with("move "));
    assert!(said != found.parameters.contains_key("sigma"));
    assert!((found.parameters["mass"].value / MASS - 1.0).abs() < 0.01);
}

#[test]
fn a_prediction_from_the_motion_alone_is_as_good_as_the_fit() {
    let recording = recording();
    let signals = prepare(&recording, &Preprocess::default()).unwrap();
    let found = identify_karnopp(&signals, &KarnoppOptions::default()).unwrap();
    let predicted = Model::from(&found).predict(&recording).unwrap();
    assert_eq!(predicted.len(), recording.len());
    // behind the filter of the fit: at each sample alone, the error of 95 kg times an acceleration is most of it
    let (predicted, force) = (signals.condition(&predicted), signals.condition(&recording.force));
    let norm = |s: &mut dyn Iterator<Item = f64>| s.map(|x| x * x).sum::<f64>().sqrt();
    let error =
        norm(&mut predicted.iter().zip(&force).map(|(p, f)| p - f)) / norm(&mut force.iter().copied());
    println!("off by {:.2} %, the fit by {:.2} %", 100.0 * error, 100.0 * found.relative_error);
    assert!(error < 1.3 * found.relative_error);
}
