//! What a motion channel costs a simulation that is driven by it: effects that sit in the velocity or the acceleration
//! channel, told by comparing channels ([`crate::agreement`]) and weighed by what they do to the force.

use crate::agreement::Column;
use crate::flips::gain_interval;
use crate::known_error::{self, Errors};
use crate::result::{Location, Missing, Quantity};
use crate::term::Stage;
use crate::track::Track;
use crate::wave::Wave;
use std::collections::BTreeMap;

/// Blocks of the interval.
const BLOCKS: usize = 24;

/// What was found in the motion channels of the recordings, before it was repaired.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Channel {
    /// The velocity column, where it is late.
    pub velocity: Option<Column>,
    /// The acceleration column, where its scale or zero is off.
    pub acceleration: Option<Column>,
    /// The wave on the position, where there is one.
    pub encoder: Option<Wave>,
}

/// Effects of the motion channels that matter for the force, each with where it does. `coefficients` are the baseline's.
pub fn missing(
    channel: &Channel,
    stage: &Stage,
    coefficients: &[f64],
    rotary: bool,
    seed: u64,
) -> Vec<(Missing, Vec<Location>)> {
    let [mass, c_p, c_n, b_p, b_n, ..] = *coefficients else { return Vec::new() };
    let friction = |v: f64| if v > 0.0 { c_p + b_p * v } else { -c_n + b_n * v };
    let located = |id: &str, cost: Option<Cost>, parameters, surest| {
        let cost = cost?;
        let missing = entry(id, &cost, parameters, surest)?;
        let regions = known_error::regions(stage, &cost.errors, rotary, missing.p);
        Some((missing, regions))
    };
    let mut out = Vec::new();
    if let Some(column) = channel.velocity {
        let longest = stage.tracks.iter().map(|t| t.raw.dt).fold(0.0, f64::max);
        let cost = cost(stage, seed, |t| {
            let shift = |series: &[f64]| crate::sensor::delayed(series, column.lag.0, t.raw.dt);
            let (late, sign) = (shift(&t.v), shift(&t.sign));
            // up to a sample is how an estimator is made; a later one turns friction round behind the body
            let turns = column.lag.0 > longest;
            (0..t.len())
                .map(|i| match t.sign[i] * sign[i] > 0.0 {
                    true => Some(friction(late[i]) - friction(t.v[i])).filter(|_| fast(t, i)),
                    false => turns.then_some(-t.sign[i] * (c_p + c_n)),
                })
                .collect()
        });
        let parameters = vec![("lag", column.lag, "s".to_string())];
        out.extend(located("velocity_lag", cost, parameters, column.lag));
    }
    if let Some(column) = channel.acceleration {
        let gain = (column.scale.0 - 1.0, column.scale.1);
        let cost = cost(stage, seed, |t| {
            let error = |i: usize| mass * (gain.0 * t.a[i] + column.zero.0);
            (0..t.len()).map(|i| Some(error(i)).filter(|_| fast(t, i))).collect()
        });
        let unit = if rotary { "rad/s²" } else { "m/s²" };
        let parameters = vec![("gain", gain, "1".to_string()), ("zero", column.zero, unit.to_string())];
        let surest =
            if (gain.0 / gain.1).abs() > (column.zero.0 / column.zero.1).abs() { gain } else { column.zero };
        out.extend(located("accelerometer_error", cost, parameters, surest));
    }
    if let Some(wave) = channel.encoder {
        let cost = cost(stage, seed, |t| {
            let error = |i: usize| {
                let (x, v, a) = (t.x[i], t.v[i], t.a[i]);
                let viscous = if v > 0.0 { b_p } else { b_n };
                mass * wave.acceleration(x, v, a) + viscous * wave.velocity(x, v)
            };
            (0..t.len()).map(|i| Some(error(i)).filter(|_| fast(t, i))).collect()
        });
        let unit = if rotary { "rad" } else { "m" };
        let parameters = vec![
            ("amplitude", wave.amplitude, unit.to_string()),
            ("phase", wave.phase, "rad".to_string()),
            ("wavelength", wave.wavelength, unit.to_string()),
        ];
        out.extend(located("encoder_eccentricity", cost, parameters, wave.amplitude));
    }
    out
}

/// Root mean square error of a sample's force with the channel as recorded, and repaired, and the interval of the
/// difference.
struct Cost {
    before: f64,
    after: f64,
    interval: [f64; 2],
    errors: Errors,
}

/// Whether a sample is in motion: at rest the force is whatever balances.
fn fast(t: &Track, i: usize) -> bool {
    t.v[i].abs() > 0.5 * t.guard()
}

/// What the error `of` a track's force does beside the noise of a sample, over the samples at which it is known.
fn cost(stage: &Stage, seed: u64, of: impl Fn(&Track) -> Vec<Option<f64>>) -> Option<Cost> {
    let samples: usize = stage.tracks.iter().map(Track::len).sum();
    let mut sums = vec![[0.0; 3]; BLOCKS];
    let mut first = 0;
    let errors: Errors = stage.tracks.iter().map(of).collect();
    for (t, errors) in stage.tracks.iter().zip(&errors) {
        for (i, error) in errors.iter().enumerate().filter_map(|(i, error)| Some((i, (*error)?))) {
            let block = &mut sums[(first + i) * BLOCKS / samples];
            let noise = t.noise.force * t.noise.force;
            *block = [block[0] + noise + error * error, block[1] + noise, block[2] + 1.0];
        }
        first += t.len();
    }
    let part = |k: usize| -> Vec<f64> { sums.iter().map(|s| s[k]).collect() };
    let (before, after, count) = (part(0), part(1), part(2));
    let total = |s: &[f64]| s.iter().sum::<f64>();
    let rms = |s: &[f64]| (total(s) / total(&count)).sqrt();
    let interval = gain_interval(&before, &after, &count, &[], 1000, seed);
    // less than this share of the noise is not worth a name, however sure
    let error = (rms(&before).powi(2) - rms(&after).powi(2)).max(0.0).sqrt();
    let counts = interval[0] > 0.0 && error > crate::floor::REGULAR * rms(&after);
    let (before, after) = (rms(&before), rms(&after));
    counts.then_some(Cost { before, after, interval, errors })
}

fn entry(
    id: &str,
    cost: &Cost,
    parameters: Vec<(&str, (f64, f64), String)>,
    surest: (f64, f64),
) -> Option<Missing> {
    let effect = OF_CHANNELS.iter().find(|e| e.0 == id)?;
    let parameters: BTreeMap<String, Quantity> = parameters
        .into_iter()
        .map(|(name, (value, std), unit)| (name.to_string(), Quantity { value, std, unit }))
        .collect();
    Some(Missing {
        effect: id.into(),
        says: effect.1.into(),
        equation: effect.2.into(),
        parameters,
        rms_heldout_before: cost.before,
        rms_heldout_after: cost.after,
        gain_ci95: cost.interval,
        // beyond five standard deviations the tail of a normal variable is no longer known better than this
        p: (-0.5 * (surest.0 / surest.1).powi(2)).exp().max(1e-12),
        indistinguishable_from: Vec::new(),
        experiment: effect.3.into(),
    })
}

/// Effects that are told by comparing channels: id, sentence, equation, what confirms them.
pub const OF_CHANNELS: &[(&str, &str, &str, &str)] = &[
    (
        "velocity_lag",
        "the velocity channel lags, so friction seems to reverse late",
        "v_column(t) = v(t − lag), v the derivative of the position",
        "no move is needed: recompute the velocity from the position, or set the estimator's filter faster",
    ),
    (
        "accelerometer_error",
        "the accelerometer has another scale or zero than the position says",
        "a_column = (1 + gain)·a + zero, a the second derivative of the position",
        "no move is needed: turn the accelerometer over in gravity, +1 g against −1 g",
    ),
    (
        "encoder_eccentricity",
        "the encoder disc is eccentric, so the position carries a wave",
        "x = x_true + amplitude·cos(2π·x_true/wavelength + phase)",
        "no move is needed: centre the disc, read it by two heads opposite each other, or subtract the wave",
    ),
];
