//! The public benchmarks by their official protocols, on the official recordings.

#[macro_use]
extern crate untested; // `println!` is shown only when a test fails, or with --nocapture

use benchmark::{Found, emps, silverbox};
use std::process::ExitCode;
use std::time::Instant;
use untested::{Need, recordings};

static SILVERBOX: Need = Need::new(|| recordings("silverbox/SNLS80mV.mat").err());
static EMPS: Need = Need::new(|| recordings("emps/DATA_EMPS.mat").err());

fn main() -> ExitCode {
    untested::run!(
        tests![silverbox_free_run_is_within_its_bars].needing(&SILVERBOX),
        tests![emps_free_run_on_the_half_left_out, the_official_test_file_is_run_when_it_is_there]
            .needing(&EMPS),
    )
}

fn silverbox_free_run_is_within_its_bars() {
    let began = Instant::now();
    let record = silverbox::read(&recordings("silverbox").unwrap()).unwrap();
    let found = silverbox::train(&record).unwrap();
    println!("{:.1?}, {} runs", began.elapsed(), found.fitted.evaluations);
    for ((place, value), std) in found.places.iter().zip(&found.fitted.values).zip(&found.fitted.std) {
        println!("{:26} {value:12.5e} ± {std:.1e} {}", place.name(), place.unit());
        assert!(*std > 0.0 && *std < 0.5 * value.abs().max(1e-6), "{}", place.name());
    }
    assert!(found.fitted.converged && found.places.len() <= 12);
    for (test, bar) in silverbox::test(&found, &record).iter().zip([0.39, 0.56, 0.38]) {
        println!("{:18} {:.4} mV, bar {bar}", test.name, test.error);
        assert!(test.error <= bar, "{}: {} mV", test.name, test.error);
    }
}

fn emps_free_run_on_the_half_left_out() {
    let began = Instant::now();
    let (record, _) = emps::read(&recordings("emps").unwrap()).unwrap();
    let [first, second] = emps::halves(&record);
    let mut squares = 0.0;
    for (fitted, judged) in [(&first, &second), (&second, &first)] {
        let found = emps::train(&record, fitted).unwrap();
        for ((place, value), std) in found.places.iter().zip(&found.fitted.values).zip(&found.fitted.std) {
            println!("{:38} {value:10.4} ± {std:.2} {}", place.name(), place.unit());
        }
        let position = 1e3 * found.free_run_error(&record, judged, emps::PROTOCOL.settling);
        let [recorded, filtered] = emps::force_error(&found, &record, judged).unwrap();
        let windows =
            |found: &Found| 1e3 * found.window_error(&record, judged, emps::WINDOW, emps::PROTOCOL.settling);
        let (ours, published) = (windows(&found), windows(&emps::published()));
        println!(
            "free run {position:.2} mm, force {recorded:.3} N, {filtered:.3} N filtered, {:.1?}",
            began.elapsed()
        );
        println!("over windows {ours:.4} mm, published five parameters {published:.4} mm");
        squares += 0.5 * position * position;
        // the published parameters were fitted to both halves
        assert!(found.fitted.converged && found.places.len() <= 12 && ours < 0.9 * published);
        assert!(recorded < 2.6 && filtered < 2.1);
    }
    // the offset of the force is another one in the other half; no structure took this below 5.7 mm
    assert!(squares.sqrt() < 6.5, "{} mm", squares.sqrt());
}

fn the_official_test_file_is_run_when_it_is_there() {
    let dir = tempfile::tempdir().unwrap();
    let official = recordings("emps/DATA_EMPS.mat").unwrap();
    std::fs::copy(&official, dir.path().join("DATA_EMPS.mat")).unwrap();
    // stands in for the record that is kept back
    std::fs::copy(&official, dir.path().join("DATA_EMPS_PULSES.mat")).unwrap();
    let answer = emps::run(dir.path(), false, &|_, _| ()).unwrap();
    let text = answer.describe();
    println!("{text}");
    assert_eq!((answer.tests.len(), answer.tests[0].official, answer.missing.clone()), (1, true, None));
    // what was fitted, run in one piece
    assert!(answer.tests[0].error < 3.0);
    let folder = dir.path().display().to_string();
    let wide = text.lines().filter(|l| l.chars().count() > 100 && !l.contains(&folder));
    assert_eq!(wide.collect::<Vec<_>>(), Vec::<&str>::new());
    let json = serde_json::to_value(&answer).unwrap();
    assert_eq!(json["schema"], "tribos.benchmark/1");
    assert_eq!(json["parameters"].as_array().unwrap().len(), 10);
    assert!(json["parameters"][0]["value"].as_f64().unwrap() > 90.0);
}
