//! The final model as `model.toml`: what was fitted, ready to predict, to simulate and to be a preset.

use crate::engine::BASELINE;
use crate::intake::Intake;
use crate::search::Hypothesis;
use crate::term::{Stage, TermKind};
use friction::effects::{Effect, EffectKind};
use friction::{Karnopp, Law};
use identify::{Geometry, Model, Preprocess, Recording, SensorEffect, prepare};
use rayon::prelude::*;

/// The model of a hypothesis, behind the filter at `cutoff` Hz.
pub fn model(intake: &Intake, stage: &Stage, found: &Hypothesis, cutoff: f64) -> Model {
    let c = |i: usize| found.fit.coefficients.get(i).copied().unwrap_or(0.0);
    // Sliding only was fitted: the static levels are those of sliding, and Δv comes last.
    // Where one level lies below zero there is a constant in the force, which while sliding is half their difference.
    let offset = if c(1) < 0.0 || c(2) < 0.0 { 0.5 * (c(1) - c(2)) } else { 0.0 };
    let (c_p, c_n) = ((c(1) - offset).max(0.0), (c(2) + offset).max(0.0));
    let law = Karnopp { c_p, c_n, b_p: c(3), b_n: c(4), d_p: c_p, d_n: c_n, delta_v: 0.0 };
    let mut model = Model {
        geometry: if intake.rotary { Geometry::Rotary } else { Geometry::Linear },
        mass: c(0).max(0.0),
        law: Law::Karnopp(law),
        cutoff_hz: Some(cutoff),
        ..Model::default()
    };
    for ((name, ..), std) in BASELINE.iter().zip(&found.fit.deviations) {
        let name = match *name {
            "coulomb_p" => "f_dynamic_p",
            "coulomb_n" => "f_dynamic_n",
            "viscous_p" => "damping_p",
            "viscous_n" => "damping_n",
            other => other,
        };
        model.std.insert(name.into(), *std);
    }
    model.nuisances.offset = offset;
    if stage.delay {
        model.nuisances.delay_s = c(BASELINE.len());
    }
    for (i, atom) in found.atoms.iter().enumerate() {
        let gains = atom.gains(found.coefficients(stage, i));
        let shape = atom.term.shape;
        match atom.term.kind {
            TermKind::Force(EffectKind::Offset) => model.nuisances.offset += gains[0],
            TermKind::Force(kind) => model.set_effect(Effect { kind, gains, shape }),
            TermKind::Sensor(sensor) if sensor.id == "time_skew" => {
                model.nuisances.delay_s += (gains[0] - gains[1]) * shape[0];
            }
            TermKind::Sensor(sensor) => {
                let named = |list: &[friction::effects::Parameter], values: &[f64], name: &str| {
                    list.iter().position(|p| p.name == name).and_then(|at| values.get(at)).copied()
                };
                let value = |name: &str| {
                    named(sensor.gains, &gains, name).or_else(|| named(sensor.shape, &shape, name))
                };
                model.nuisances.sensors.extend(SensorEffect::from_parts(sensor.id, value));
            }
        }
    }
    model.law = Law::Karnopp(Karnopp { delta_v: rest_band(&model, intake, stage), ..law });
    model
}

/// Speeds tried for the band of rest, as shares of the top speed.
const BANDS: [f64; 9] = [0.0025, 0.004, 0.0065, 0.01, 0.016, 0.025, 0.04, 0.065, 0.1];
/// Samples it is chosen on, at most.
const LONGEST: usize = 60_000;

/// Δv of the law: speeds below it count as rest, where friction is whatever balances.
///
/// The fit looks at sliding only, but a prediction has to go through every reversal. There the force does not jump as
/// sgn v does. The band with the smallest error of prediction, over all samples of the recordings that were fitted, is
/// taken if it also is better than none in either half of them.
fn rest_band(model: &Model, intake: &Intake, stage: &Stage) -> f64 {
    let Law::Karnopp(law) = model.law else { return 0.0 };
    let top = stage.tracks.iter().flat_map(|t| &t.v).fold(0.0f64, |m, v| m.max(v.abs()));
    let mut left = LONGEST;
    let mut parts = Vec::new();
    for stretch in &intake.stretches {
        let n = stretch.position.len().min(left);
        left -= n;
        let column = |c: &Option<Vec<f64>>| c.as_ref().map(|c| c[..n].to_vec());
        let recording = Recording {
            geometry: model.geometry,
            time: (0..n).map(|i| i as f64 * stretch.dt).collect(),
            position: stretch.position[..n].to_vec(),
            force: stretch.force[..n].to_vec(),
            velocity: column(&stretch.velocity),
            acceleration: column(&stretch.acceleration),
            normal_force: column(&stretch.normal),
            ..Recording::default()
        };
        parts.extend(prepare(&recording, &Preprocess::Tribos { cutoff_hz: model.cutoff_hz }).ok());
    }
    let error = |band: f64| -> [f64; 2] {
        let model = Model { law: Law::Karnopp(Karnopp { delta_v: band, ..law }), ..model.clone() };
        let mut squares = Vec::new();
        for part in &parts {
            let (predicted, measured) =
                (part.condition(&model.predict_signals(part)), part.condition(&part.force));
            squares.extend(predicted.iter().zip(measured).map(|(p, m)| (p - m) * (p - m)));
        }
        let (early, late) = squares.split_at(squares.len() / 2);
        [early.iter().sum(), late.iter().sum()]
    };
    let none = error(0.0);
    let tried: Vec<(f64, [f64; 2])> =
        BANDS.par_iter().map(|share| (share * top, error(share * top))).collect();
    let best = tried.iter().min_by(|a, b| (a.1[0] + a.1[1]).total_cmp(&(b.1[0] + b.1[1])));
    best.filter(|(_, e)| e[0] < none[0] && e[1] < none[1]).map_or(0.0, |(band, _)| *band)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_carries_every_sensor_effect_that_can_be_named() {
        for sensor in crate::sensor::ALL.iter().filter(|s| s.id != "time_skew") {
            let known = SensorEffect::ALL.iter().find(|(id, _)| *id == sensor.id);
            let (_, fields) =
                known.unwrap_or_else(|| panic!("{} is not in identify::SensorEffect", sensor.id));
            for parameter in sensor.gains.iter().chain(sensor.shape) {
                assert!(fields.contains(&parameter.name), "{}.{}", sensor.id, parameter.name);
            }
        }
    }
}
