//! What a motion channel costs a simulation that is driven by it: effects that sit in the velocity or the acceleration
//! channel, found by comparing channels ([`signals::prepare`]) and weighted by their influence on the force.

use crate::findings::known_error::{self, Errors};
use crate::library::design_matrix::DesignMatrix;
use crate::preparation::track::Track;
use crate::regression::sign_flips::gain_interval;
use crate::result::{Location, Missing, Quantity as Quantified};
use friction::Geometry;
use friction::effects::{self, About, CATALOGUE, Quantity, Seat};
use signals::{Column, Wave};
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
    design: &DesignMatrix,
    coefficients: &[f64],
    geometry: Geometry,
    seed: u64,
) -> Vec<(Missing, Vec<Location>)> {
    let [mass, c_p, c_n, b_p, b_n] = design.physics(coefficients);
    let friction = |v: f64| if v > 0.0 { c_p + b_p * v } else { -c_n + b_n * v };
    let located = |channel: Quantity, cost: Option<Cost>, estimates: &[(f64, f64)], surest| {
        let cost = cost?;
        let missing = entry(channel, &cost, estimates, surest, geometry)?;
        let regions = known_error::regions(design, &cost.errors, geometry, missing.p);
        Some((missing, regions))
    };
    let mut out = Vec::new();
    if let Some(column) = channel.velocity {
        let longest = design.tracks.iter().map(|t| t.raw.dt).fold(0.0, f64::max);
        let cost = cost(design, seed, |t| {
            let shift = |series: &[f64]| friction::effects::delayed(series, column.lag.0, t.raw.dt);
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
        out.extend(located(Quantity::Velocity, cost, &[column.lag], column.lag));
    }
    if let Some(column) = channel.acceleration {
        let gain = (column.scale.0 - 1.0, column.scale.1);
        let cost = cost(design, seed, |t| {
            let error = |i: usize| mass * (gain.0 * t.a[i] + column.zero.0);
            (0..t.len()).map(|i| Some(error(i)).filter(|_| fast(t, i))).collect()
        });
        let surest =
            if (gain.0 / gain.1).abs() > (column.zero.0 / column.zero.1).abs() { gain } else { column.zero };
        out.extend(located(Quantity::Acceleration, cost, &[gain, column.zero], surest));
    }
    if let Some(wave) = channel.encoder {
        let cost = cost(design, seed, |t| {
            let error = |i: usize| {
                let (x, v, a) = (t.x[i], t.v[i], t.a[i]);
                let viscous = if v > 0.0 { b_p } else { b_n };
                mass * wave.acceleration(x, v, a) + viscous * wave.velocity(x, v)
            };
            (0..t.len()).map(|i| Some(error(i)).filter(|_| fast(t, i))).collect()
        });
        let estimates = [wave.amplitude, wave.phase, wave.wavelength];
        out.extend(located(Quantity::Position, cost, &estimates, wave.amplitude));
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
fn cost(design: &DesignMatrix, seed: u64, of: impl Fn(&Track) -> Vec<Option<f64>>) -> Option<Cost> {
    let samples: usize = design.tracks.iter().map(Track::len).sum();
    let mut sums = vec![[0.0; 3]; BLOCKS];
    let mut first = 0;
    let errors: Errors = design.tracks.iter().map(of).collect();
    for (t, errors) in design.tracks.iter().zip(&errors) {
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
    let counts = interval[0] > 0.0 && error > crate::findings::floor::REGULAR * rms(&after);
    let (before, after) = (rms(&before), rms(&after));
    counts.then_some(Cost { before, after, interval, errors })
}

/// The effect that a difference between this channel and the others shows.
fn of_channel(channel: Quantity) -> Option<&'static About> {
    CATALOGUE.iter().copied().find(|a| a.comparison.is_some() && a.seat == Seat::Channel(channel))
}

/// Whether an effect is a fault of a channel that comparing the channels repairs: nothing that a simulation must contain to
/// reproduce the force.
pub fn is_repaired(id: &str) -> bool {
    let seat = effects::about(id).map(|about| about.seat);
    matches!(seat, Some(Seat::Channel(Quantity::Velocity | Quantity::Acceleration)))
}

/// Whether an effect is found by comparing channels.
pub fn told_by_channels(id: &str) -> bool {
    effects::about(id).is_some_and(|about| about.comparison.is_some())
}

/// The effect of a channel, with estimates and standard deviations of what the comparison estimates.
fn entry(
    channel: Quantity,
    cost: &Cost,
    estimates: &[(f64, f64)],
    surest: (f64, f64),
    geometry: Geometry,
) -> Option<Missing> {
    let about = of_channel(channel)?;
    let comparison = about.comparison?;
    let parameters: BTreeMap<String, Quantified> = comparison
        .parameters
        .iter()
        .zip(estimates)
        .map(|(parameter, &(value, std))| {
            let unit = parameter.unit(geometry).to_string();
            (parameter.name.to_string(), Quantified { value, std, unit })
        })
        .collect();
    Some(Missing {
        effect: about.id.into(),
        says: about.says.into(),
        equation: comparison.equation.into(),
        parameters,
        rms_heldout_before: cost.before,
        rms_heldout_after: cost.after,
        gain_ci95: cost.interval,
        // beyond five standard deviations the tail of a normal variable is no longer known better than this
        p: (-0.5 * (surest.0 / surest.1).powi(2)).exp().max(1e-12),
        indistinguishable_from: Vec::new(),
        experiment: comparison.confirmed_by.into(),
        free_form: None,
    })
}
