//! The whole story: the command as a user runs it, and what it leaves behind.

use std::path::Path;
use std::process::{Command, Output};

fn tribos(dir: &Path, arguments: &[&str]) -> Output {
    let out = Command::new(env!("CARGO_BIN_EXE_tribos")).args(arguments).current_dir(dir).output().unwrap();
    let said = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    println!("$ tribos {}\n{said}", arguments.join(" "));
    out
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn the_demo_names_what_it_concealed_and_leaves_every_file() {
    let dir = tempfile::tempdir().unwrap();
    let out = tribos(dir.path(), &["demo", "--out", "story", "--conceal", "cogging", "--seed", "3"]);
    assert_eq!(out.status.code(), Some(0));
    let story = dir.path().join("story");
    for name in ["recording.csv", "identification.json", "diagnosis.json", "model.toml", "report.html"] {
        assert!(std::fs::metadata(story.join(name)).unwrap().len() > 100, "{name}");
    }
    let identified = json(&story.join("identification.json"));
    assert_eq!(identified["schema"], "tribos.identification/1");
    let mass = identified["parameters"]["mass"]["value"].as_f64().unwrap();
    assert!((mass - plant::materials::BRASS.mass).abs() < 0.05, "mass {mass} kg");
    let found = json(&story.join("diagnosis.json"));
    assert_eq!(found["schema"], "tribos.diagnosis/2");
    assert_eq!(found["verdict"], "mismatch");
    let missing = found["missing"].as_array().unwrap();
    let named = missing.iter().find(|m| m["effect"] == "cogging").expect("cogging is named");
    let wavelength = named["parameters"]["wavelength"]["value"].as_f64().unwrap();
    assert!((wavelength - 0.004).abs() < 4e-5, "concealed 4 mm, found {wavelength} m");
    assert!(named["gain_ci95"][0].as_f64().unwrap() > 0.0);
    let report = std::fs::read_to_string(story.join("report.html")).unwrap();
    for forbidden in ["src=\"http", "href=\"http", "@import", "url(http"] {
        assert!(!report.contains(forbidden), "the report reaches for the network: {forbidden}");
    }
    // the model it leaves predicts the recording it came from
    let out = tribos(&story, &["predict", "--model", "model.toml", "recording.csv", "--out", "pred.csv"]);
    assert_eq!(out.status.code(), Some(0));
    let lines = |name: &str| {
        let text = std::fs::read_to_string(story.join(name)).unwrap();
        text.lines().filter(|l| !l.starts_with('#')).count()
    };
    assert_eq!(lines("pred.csv"), lines("recording.csv"), "a prediction at every sample");
    // and is a preset: the device takes all of it, what was found included
    let out = tribos(&story, &["preset", "push", "sim", "model.toml", "--name", "found"]);
    assert_eq!(out.status.code(), Some(0));
    assert!(std::fs::read_to_string(story.join("model.toml")).unwrap().contains("cogging."));
}

#[test]
fn record_identify_simulate_and_convert_hand_their_files_to_each_other() {
    let dir = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let out = tribos(dir.path(), arguments);
        assert_eq!(out.status.code(), Some(0), "{arguments:?}");
    };
    let motion = "multisine 0.01 0.8 6";
    run(&["record", "sim", "--out", "a.csv", "--block", "rubber", "--move", motion]);
    run(&["identify", "a.csv", "--out", "a.toml", "--json", "a.json", "--report", "a.html"]);
    run(&["simulate", "--model", "a.toml", "--move", motion, "--out", "b.csv"]);
    run(&["convert", "b.csv", "b.mat"]);
    run(&["convert", "b.csv", "b.mcap"]);
    run(&["identify", "b.mat", "--json", "b.json"]);
    let mass = |name: &str| json(&dir.path().join(name))["parameters"]["mass"]["value"].as_f64().unwrap();
    let (recorded, simulated) = (mass("a.json"), mass("b.json"));
    println!("mass: recorded {recorded} kg, identified again from its simulation {simulated} kg");
    assert!((recorded - simulated).abs() < 0.05 * recorded);
    let mcap = std::fs::read(dir.path().join("b.mcap")).unwrap();
    assert!(mcap.starts_with(b"\x89MCAP0\r\n") && mcap.ends_with(b"\x89MCAP0\r\n"));
    assert!(!dir.path().join("a.csv.part").exists());
}
