//! The final model as `model.toml`: what was fitted, ready to predict, to simulate and to be a preset.

use crate::engine::BASELINE;
use crate::intake::Intake;
use crate::search::Hypothesis;
use crate::term::{Stage, TermKind};
use friction::effects::{Effect, EffectKind};
use friction::{Karnopp, Law};
use identify::{Geometry, Model, SensorEffect};

/// The model of a hypothesis, behind the filter at `cutoff` Hz.
pub fn model(intake: &Intake, stage: &Stage, found: &Hypothesis, cutoff: f64) -> Model {
    let c = |i: usize| found.fit.coefficients.get(i).copied().unwrap_or(0.0);
    // Sliding only was fitted: the static levels are those of sliding. A level that came out below zero is zero.
    let (c_p, c_n) = (c(1).max(0.0), c(2).max(0.0));
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
    if stage.delay {
        model.nuisances.delay_s = c(BASELINE.len());
    }
    for (i, atom) in found.atoms.iter().enumerate() {
        let gains = atom.gains(found.coefficients(stage, i));
        let shape = atom.term.shape;
        match atom.term.kind {
            TermKind::Force(EffectKind::Offset) => model.nuisances.offset += gains[0],
            TermKind::Force(kind) => model.set_effect(Effect { kind, gains, shape }),
            TermKind::Sensor(sensor) if sensor.id == "time_skew" => model.nuisances.delay_s += gains[0],
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
    model
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
