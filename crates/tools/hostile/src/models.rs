//! Models and presets, as TOML.

use crate::device::virtual_device;
use crate::one_line::is_one_line;
use identify::Model;
use signals::{Geometry, Recording};

fn read(bytes: &[u8]) -> Option<Model> {
    let text = std::str::from_utf8(bytes).ok()?;
    match Model::from_toml("model.toml", text) {
        Ok(model) => Some(model),
        Err(error) => {
            let said = error.to_string();
            is_one_line(&said);
            assert!(said.starts_with("model.toml"), "no place: {said:?}");
            None
        }
    }
}

/// A model reads back as itself, and predicts.
pub(crate) fn model(bytes: &[u8]) {
    let Some(model) = read(bytes) else { return };
    let text = model.to_toml();
    let again = Model::from_toml("model.toml", &text).expect("a model that was written");
    assert_eq!(again.to_toml(), text, "another model is read back");
    let time: Vec<f64> = (0..200).map(|k| 1e-3 * f64::from(k)).collect();
    let position: Vec<f64> = time.iter().map(|t| 0.01 * (20.0 * t).sin()).collect();
    let force = vec![0.0; time.len()];
    for geometry in [Geometry::Linear, Geometry::Rotary] {
        let recording = Recording {
            geometry,
            time: time.clone(),
            position: position.clone(),
            force: force.clone(),
            ..Recording::default()
        };
        match model.predict(&recording) {
            Ok(predicted) => assert_eq!(predicted.len(), time.len()),
            Err(error) => is_one_line(&error.to_string()),
        }
    }
}

/// A preset goes to a device, which takes or refuses each line.
pub(crate) fn preset(bytes: &[u8]) {
    let Some(model) = read(bytes) else { return };
    let mut device = virtual_device();
    let mut answers = Vec::new();
    for (name, value) in model.preset_lines() {
        let before = answers.len();
        device.write(format!("set {name} {value}\n").as_bytes());
        for _ in 0..20 {
            device.tick();
            device.read(&mut answers);
        }
        let answer = String::from_utf8_lossy(&answers[before..]).into_owned();
        assert!(answer.starts_with("ok") || answer.starts_with("err "), "`set {name} {value}`: {answer:?}");
    }
    device.write(b"render on\n");
    for _ in 0..50 {
        device.tick();
        assert!(device.outputs().force.is_finite());
    }
}
