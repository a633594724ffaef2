//! Effects of sensors and drive as columns: what each adds to the force that acts, on a filtered stretch.

use crate::preparation::track::Track;
use friction::effects::{Acts, MAX_SHAPE, Record, SeriesKind};
use signals::LowPass;

/// The force per unit of gain `gain`, at every sample, in front of the filter.
pub fn column(track: &Track, kind: SeriesKind, gain: usize, shape: &[f64; MAX_SHAPE]) -> Vec<f64> {
    let (acts, dt) = (kind.about().acts, track.raw.dt);
    let restored = acts.in_time().then(|| true_force(track, &kind.restored(gain, shape, &track.f, dt)));
    // Where a load flies on depends on the position alone, so its noise is kept out: a load that rests against one side
    // of a play would rattle in it.
    let quiet = (acts == Acts::Behind)
        .then(|| LowPass::new(0.5 * track.filter.cutoff(), dt).apply(&track.raw.position));
    let record = Record {
        dt,
        position: quiet.as_ref().unwrap_or(&track.x),
        acceleration: &track.a,
        direction: &track.sign,
        force: restored.as_ref().unwrap_or(&track.force_model),
    };
    kind.added(gain, shape, &record)
}

/// The force that acts, at every sample; `measured` is the measured one put back in time. Where the body slides it is the
/// model's, because the measured one's noise would stand on both sides of the equation, but for what is slow: there the
/// noise is little, and physics that the model does not have yet is most. Where the body may be stuck only the
/// measurement knows.
fn true_force(track: &Track, measured: &[f64]) -> Vec<f64> {
    let left: Vec<f64> =
        (0..track.len()).map(|i| track.mask[i] * (measured[i] - track.force_model[i])).collect();
    let slow = LowPass::new(SLOW * track.filter.cutoff(), track.raw.dt).apply(&left);
    (0..track.len())
        .map(|i| {
            let m = track.mask[i];
            m * (track.force_model[i] + slow[i]) + (1.0 - m) * measured[i]
        })
        .collect()
}

/// Share of the cut-off below which the force is taken from the measurement.
const SLOW: f64 = 0.2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preparation::track::Reversals;
    use friction::effects::{SeriesEffect, delayed};
    use friction::{Karnopp, Law};
    use identify::{Model, Nuisances, Preprocess, prepare};
    use signals::{Channels, Recording};
    use std::f64::consts::TAU;

    const DT: f64 = 1e-3;

    /// A slide that starts and ends at rest.
    fn recording() -> Recording {
        let window = |t: f64| (std::f64::consts::PI * ((t - 1.0) / 3.0).clamp(0.0, 1.0)).sin().powi(4);
        let place = |t: f64| 0.02 * window(t) * ((TAU * 1.3 * t).sin() + 0.3 * (TAU * 3.1 * t).cos());
        let time: Vec<f64> = (0..5000).map(|i| f64::from(i) * DT).collect();
        let position = time.iter().map(|t| place(*t)).collect();
        Recording { force: vec![0.0; time.len()], time, position, ..Recording::default() }
    }

    /// A shape that this motion shows, of whole samples where it is a time.
    fn shape(kind: SeriesKind) -> [f64; MAX_SHAPE] {
        let mut out = [0.0; MAX_SHAPE];
        for (value, parameter) in out.iter_mut().zip(kind.about().shape) {
            *value = match parameter.scale {
                friction::effects::Scale::Lag => 4.0 * DT,
                friction::effects::Scale::Frequency => 12.0,
                friction::effects::Scale::Damping => 0.1,
                friction::effects::Scale::Force => 1.2,
                _ => 0.004,
            };
        }
        out
    }

    /// The largest difference between what a fit of this effect predicts and what the model says that is written and read
    /// again, and the largest force of the effect.
    fn fit_against_model(kind: SeriesKind, gain: usize) -> (f64, f64) {
        let recording = recording();
        let law = Karnopp { c_p: 1.1, c_n: 0.9, b_p: 2.0, b_n: 1.5, d_p: 1.1, d_n: 0.9, delta_v: 0.0 };
        let mass = 0.4;
        let channels = Channels {
            dt: DT,
            position: recording.position.clone(),
            force: recording.force.clone(),
            ..Channels::default()
        };
        let mut track = Track::new(channels, 40.0, Reversals::default());
        // the direction of the motion itself, which the model goes by
        track.sign = track.v.iter().map(|v| if *v == 0.0 { 0.0 } else { v.signum() }).collect();
        track.mask.fill(1.0);
        let sliding = |v: f64| match v {
            v if v > 0.0 => law.c_p + law.b_p * v,
            v if v < 0.0 => -law.c_n + law.b_n * v,
            _ => 0.5 * (law.c_p - law.c_n),
        };
        track.force_model = track.a.iter().zip(&track.v).map(|(a, v)| mass * a + sliding(*v)).collect();
        // the force as it was recorded through the effect
        let most = kind.about().gains[gain].max;
        let share = if most > 0.0 { most.min(1.0) } else { -0.5 };
        let record = Record {
            dt: DT,
            position: &track.x,
            acceleration: &track.a,
            direction: &track.sign,
            force: &track.force_model,
        };
        let shown = kind.added(gain, &shape(kind), &record);
        track.f = track.force_model.iter().zip(&shown).map(|(f, x)| f + share * x).collect();

        let added = column(&track, kind, gain, &shape(kind));
        let fit: Vec<f64> = track.force_model.iter().zip(&added).map(|(f, x)| f + share * x).collect();

        let mut gains = [0.0; friction::effects::MAX_GAINS];
        gains[gain] = share;
        let mut nuisances = Nuisances::default();
        match kind.about().acts {
            Acts::Delay => nuisances.delay_s = kind.delay(&gains, &shape(kind)),
            _ => nuisances.sensors.push(SeriesEffect { kind, gains, shape: shape(kind) }),
        }
        let written = Model { mass, law: Law::Karnopp(law), nuisances, ..Model::default() }.to_toml();
        let model = Model::from_toml("model.toml", &written).expect("what was written");
        let mut signals =
            prepare(&recording, &Preprocess::Tribos { cutoff_hz: Some(40.0) }).expect("signals");
        let quiet = LowPass::new(20.0, DT).apply(&recording.position);
        signals.position = if kind.about().acts == Acts::Behind { quiet } else { track.x.clone() };
        (signals.velocity, signals.acceleration) = (track.v.clone(), track.a.clone());
        let predicted = model.predict_signals(&signals);
        // the ends of a series are held, and what that does to an estimate of the force dies out at rest
        let inner = 950..predicted.len() - 950;
        let worst = inner.clone().map(|i| (predicted[i] - fit[i]).abs()).fold(0.0, f64::max);
        (worst, inner.map(|i| added[i].abs()).fold(0.0, f64::max))
    }

    #[test]
    fn a_model_predicts_what_its_fit_predicted() {
        for &kind in SeriesKind::ALL {
            for gain in 0..kind.about().gains.len() {
                let (worst, size) = fit_against_model(kind, gain);
                println!(
                    "{}.{}: {worst:.1e} of {size:.2e} N",
                    kind.about().id,
                    kind.about().gains[gain].name
                );
                // the force behind a lag is estimated from a record of samples, not known
                let tolerance = if kind.about().acts == Acts::Lag { 0.05 * size } else { 1e-9 * size };
                assert!(size > 1e-3 && worst <= tolerance, "{}: {worst} of {size}", kind.about().id);
            }
        }
    }

    #[test]
    fn a_force_is_restored_as_it_was() {
        let force: Vec<f64> = (0..2000).map(|i| (TAU * 3.0 * f64::from(i) * DT).sin()).collect();
        for &kind in SeriesKind::ALL.iter().filter(|k| k.about().acts.in_time()) {
            for gain in 0..kind.about().gains.len() {
                let rest = vec![0.0; force.len()];
                let record =
                    Record { dt: DT, position: &rest, acceleration: &rest, direction: &rest, force: &force };
                let added = kind.added(gain, &[5.5e-3, 0.0], &record);
                let shown: Vec<f64> = force.iter().zip(&added).map(|(f, x)| f + x).collect();
                let restored = kind.restored(gain, &[5.5e-3, 0.0], &shown, DT);
                let worst = (100..1900).map(|i| (restored[i] - force[i]).abs()).fold(0.0, f64::max);
                println!("{} {gain}: {worst:.1e}", kind.about().id);
                assert!(worst < 2e-3);
            }
        }
        // and a delay of whole samples exactly
        let late = delayed(&force, 4.0 * DT, DT);
        assert_eq!(delayed(&late, -4.0 * DT, DT)[10..1990], force[10..1990]);
    }
}
