//! The final model as `model.toml`: what was fitted, ready to predict, to simulate and to be a preset.

use crate::library::baseline::{BASELINE, levels};
use crate::library::design_matrix::DesignMatrix;
use crate::library::term::TermKind;
use crate::preparation::intake::Intake;
use crate::search::hypothesis::Hypothesis;
use friction::effects::{Acts, Effect, SeriesEffect};
use friction::{Karnopp, Law};
use identify::{Model, Preprocess, preset_name, signals_of};
use rayon::prelude::*;
use signals::Prepared;

/// The model of a hypothesis, behind the filter at `cutoff` Hz.
pub fn model(intake: &Intake, design: &DesignMatrix, found: &Hypothesis, cutoff: f64) -> Model {
    let physics = design.physics(&found.fit.coefficients);
    let c = |i: usize| physics[i];
    // Sliding only was fitted: the static levels are those of sliding, and Δv comes last.
    let (offset, c_p, c_n) = levels(&physics);
    let law = Karnopp { c_p, c_n, b_p: c(3), b_n: c(4), d_p: c_p, d_n: c_n, delta_v: 0.0 };
    let mut model = Model {
        geometry: intake.geometry,
        mass: c(0).max(0.0),
        law: Law::Karnopp(law),
        cutoff_hz: Some(cutoff),
        ..Model::default()
    };
    for (i, std) in design.present.iter().zip(found.fit.std_errors()) {
        let parameter = &BASELINE[*i];
        model.std.insert(preset_name(model.law.id(), parameter.name).into(), *std);
    }
    model.nuisances.offset = offset;
    if design.delay {
        model.nuisances.delay_s = found.fit.coefficients[design.present.len()];
    }
    for (i, atom) in found.atoms.iter().enumerate() {
        let gains = atom.gains(found.coefficients(design, i));
        let shape = atom.term.shape;
        match atom.term.kind {
            TermKind::Force(kind) if kind.about().is_constant() => {
                model.nuisances.offset += gains.iter().sum::<f64>();
            }
            TermKind::Force(kind) => model.effects.push(Effect { kind, gains, shape }),
            TermKind::Series(kind) if kind.about().acts == Acts::Delay => {
                model.nuisances.delay_s += kind.delay(&gains, &shape);
            }
            TermKind::Series(kind) => model.nuisances.sensors.push(SeriesEffect { kind, gains, shape }),
        }
    }
    model.curves = found.free.iter().map(|t| t.form).collect();
    model.law = Law::Karnopp(Karnopp { delta_v: rest_band(&model, intake, design, cutoff), ..law });
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
fn rest_band(model: &Model, intake: &Intake, design: &DesignMatrix, cutoff: f64) -> f64 {
    let Law::Karnopp(law) = model.law else { return 0.0 };
    let top = design.tracks.iter().flat_map(|t| &t.v).fold(0.0f64, |m, v| m.max(v.abs()));
    let mut left = LONGEST;
    let mut parts = Vec::new();
    for stretch in &intake.stretches {
        let n = stretch.len().min(left);
        left -= n;
        let part = Prepared::of_stretch(stretch.first(n), model.geometry, cutoff);
        parts.extend(signals_of(part, &Preprocess::default()).ok());
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
