//! One gap-free stretch of a recording, filtered once and ready for regressors.
//!
//! Friction's physics happens at reversals, so as little as possible is left out there. The motion is estimated
//! ([`signals::estimate_motion`]), the direction is its posterior mean, and each sample weighs what is known of it
//! ([`Track::weigh`]) *before* the filter's average is formed, on both sides of the equation alike ([`Track::pass`]). A stuck
//! body's friction is whatever balances the applied force: such samples would be a mismatch for every law and information for
//! none, and left out behind the filter they would have leaked into their neighbours already.

use signals::{
    Channels, LowPass, Noise, central_difference, derived_noise, differentiated, direction, noise_std,
    quantile, spread,
};
use std::f64::consts::PI;

/// Cut-off of the filter behind which derivatives are taken, in cut-offs.
const SHARPER: f64 = 3.0;

/// Error of a crossing between two samples as a share of the time between them: the velocity is not straight there.
const MISTIMED: f64 = 0.05;

/// Error of the smallest velocities, as a share of the largest: so slow, sensors are not what their noise says.
const SLOW: f64 = 0.001;

/// Moments within the time of a sample.
const PARTS_OF_SAMPLE: [f64; 5] = [-0.4, -0.2, 0.0, 0.2, 0.4];

/// Error left by the direction, as a share of the noise, at which a sample counts half.
const TOLERATED: f64 = 0.5;

/// Share of the force below which an error is not looked at.
const NEGLIGIBLE: f64 = 0.002;

/// What is known of the direction of sliding beside the velocity.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Reversals {
    /// Δv of the baseline: speeds below it belong to its static branch, whose force is whatever balances. 0 where the
    /// recording shows no such band.
    pub static_band: f64,
    /// The direction of a body that only ever advances: it is known at every sample, however slow.
    pub one_way: Option<f64>,
}

/// The stretch behind the filter.
#[derive(Debug, Clone)]
pub struct Track {
    /// The channels it was made of.
    pub raw: Channels,
    /// What is known of its reversals.
    pub reversals: Reversals,
    /// The filter.
    pub filter: LowPass,
    /// Position, smoothed.
    pub x: Vec<f64>,
    /// Velocity, smoothed.
    pub v: Vec<f64>,
    /// Acceleration: behind the sharper filter, and smoothed around the moments at which the direction is not known. A filter
    /// blurs it as little as the force, whatever its frequency, but carries the edges of a stuck stretch into the samples
    /// beside it; the smoother does not.
    pub a: Vec<f64>,
    /// The same of the smoother alone.
    smoothed: Vec<f64>,
    /// Standard deviation of the acceleration.
    pub a_std: Vec<f64>,
    /// Force behind the sharper filter.
    pub f: Vec<f64>,
    /// Normal load behind the filter.
    pub normal: Option<Vec<f64>>,
    /// Sliding direction: −1 or 1. It does not flicker in noise.
    pub sign: Vec<f64>,
    /// Posterior mean of the direction, from −1 to 1, over the time of a sample as the acceleration shows it.
    pub direction: Vec<f64>,
    /// What is not known of the direction: 1 − E[sgn v]², 1 in the static branch.
    pub unknown: Vec<f64>,
    /// Weight of a sample, from 0, where the body may be stuck or the filter has not settled, to 1.
    pub mask: Vec<f64>,
    /// The force as the baseline predicts it: what stands for "the applied force" inside a regressor, because
    /// the measured force's own noise there would correlate with itself.
    pub force_model: Vec<f64>,
    /// Distance since the last reversal.
    pub distance: Vec<f64>,
    /// Time since the last reversal, s.
    pub since: Vec<f64>,
    /// Samples averaged into one row.
    pub stride: usize,
    /// Noise of the channels.
    pub noise: Noise,
}

/// The acceleration behind `sharp`, of all channels that show it, by their noise behind the filter.
fn differentiated_twice(raw: &Channels, cutoff: f64, sharp: &LowPass, noise: &Noise) -> Vec<f64> {
    let dt = raw.dt;
    let twice = central_difference(&central_difference(&sharp.apply(&raw.position), dt), dt);
    let mut sources = vec![(twice, noise.position * differentiated(2, cutoff, dt))];
    if let Some(column) = &raw.velocity {
        let once = central_difference(&sharp.apply(column), dt);
        sources.push((once, noise_std(column) * differentiated(1, cutoff, dt)));
    }
    if let Some(column) = &raw.acceleration {
        sources.push((sharp.apply(column), noise_std(column) * differentiated(0, cutoff, dt)));
    }
    let information: Vec<f64> = sources.iter().map(|(_, s)| 1.0 / (s * s).max(1e-300)).collect();
    let total: f64 = information.iter().sum();
    let mut out = vec![0.0; raw.len()];
    for ((series, _), share) in sources.iter().zip(&information) {
        for (o, x) in out.iter_mut().zip(series) {
            *o += share / total * x;
        }
    }
    out
}

impl Track {
    /// Estimates the motion behind the channels, filters them at `cutoff` Hz and finds where the direction is known.
    pub fn new(raw: Channels, cutoff: f64, reversals: Reversals) -> Self {
        let dt = raw.dt;
        let filter = LowPass::new(cutoff, dt);
        let sharp = LowPass::new((SHARPER * cutoff).min(0.3 / dt), dt);
        let instant = if raw.acceleration.is_some() { 1.0 } else { 0.0 };
        let mut noise = derived_noise(&raw, cutoff);
        let motion = raw.motion();
        let v_std: Vec<f64> = (0..motion.len()).map(|i| motion.velocity_std(i)).collect();
        let a_std: Vec<f64> = (0..motion.len()).map(|i| motion.acceleration_std(i)).collect();
        noise.velocity = quantile(&v_std, 0.5);

        let n = motion.len();
        let stride = ((1.0 / dt) / (2.5 * cutoff)).round().max(1.0) as usize;
        let f = sharp.apply(&raw.force);
        let mut track = Self {
            filter,
            x: motion.position.clone(),
            v: motion.velocity.clone(),
            a: differentiated_twice(&raw, cutoff, &sharp, &noise),
            smoothed: motion.acceleration.clone(),
            a_std,
            normal: raw.normal.as_ref().map(|c| filter.apply(c)),
            force_model: f.clone(),
            f,
            sign: vec![1.0; n],
            direction: vec![1.0; n],
            unknown: vec![0.0; n],
            mask: vec![1.0; n],
            distance: vec![0.0; n],
            since: vec![0.0; n],
            stride,
            noise,
            reversals,
            raw,
        };
        track.find_signs();
        track.find_directions(&v_std, instant);
        track.measure_reversals();
        track
    }

    /// Velocity below which the direction is not known.
    pub fn guard(&self) -> f64 {
        (3.0 * self.noise.velocity).max(3.0 * SLOW * self.fast()).max(self.reversals.static_band)
    }

    fn fast(&self) -> f64 {
        quantile(&self.v.iter().map(|v| v.abs()).collect::<Vec<_>>(), 0.95)
    }

    /// The direction before and behind every moment at which it changes.
    fn find_signs(&mut self) {
        if let Some(way) = self.reversals.one_way {
            self.sign.fill(way);
            return;
        }
        let n = self.v.len();
        let guard = self.guard();
        let mut i = 0;
        let mut direction = self.v.iter().find(|v| v.abs() >= guard).map_or(1.0, |v| v.signum());
        while i < n {
            if self.v[i].abs() >= guard {
                direction = self.v[i].signum();
                self.sign[i] = direction;
                i += 1;
                continue;
            }
            let start = i;
            // not `< guard`: what is no number would be neither, and the loop would not end
            while i < n && !(self.v[i].abs() >= guard) {
                i += 1;
            }
            let after = if i < n { self.v[i].signum() } else { direction };
            // The most likely moment of the crossing is the last change of sign inside.
            let change =
                (start.max(1)..i).rev().find(|&j| self.v[j] * after > 0.0 && self.v[j - 1] * after <= 0.0);
            let change = change.unwrap_or((start + i) / 2).clamp(start, i);
            for j in start..i {
                self.sign[j] = if j < change { direction } else { after };
            }
            direction = after;
        }
    }

    /// Posterior mean and variance of the direction. `instant` is the share of the acceleration that is measured at the
    /// instant of a sample; the rest is  and shows a reversal between two samples as the mean over the time of
    /// each.
    fn find_directions(&mut self, v_std: &[f64], instant: f64) {
        if let Some(way) = self.reversals.one_way {
            self.direction.fill(way);
            return;
        }
        let n = self.v.len();
        let fast = self.fast();
        for (i, v_std) in v_std.iter().enumerate() {
            let (before, here, after) = (self.v[i.saturating_sub(1)], self.v[i], self.v[(i + 1).min(n - 1)]);
            let least = v_std.hypot(SLOW * fast);
            let std = least.hypot(MISTIMED * 0.5 * (after - before));
            let (mut mean, mut square) = (0.0, 0.0);
            for part in PARTS_OF_SAMPLE {
                let v = if part < 0.0 { here + part * (here - before) } else { here + part * (after - here) };
                let e = direction(v, std);
                mean += e / PARTS_OF_SAMPLE.len() as f64;
                square += e * e / PARTS_OF_SAMPLE.len() as f64;
            }
            let at_once = direction(here, least);
            self.direction[i] = instant * at_once + (1.0 - instant) * mean;
            self.unknown[i] = 1.0 - (instant * at_once * at_once + (1.0 - instant) * square);
            if here.abs() < self.reversals.static_band {
                self.unknown[i] = 1.0;
            }
        }
    }

    /// Weighs each sample: a direction that is not known leaves an error of the `friction`, a motion that jerks one of the
    /// acceleration of `mass`, beside the noise of the force.
    pub fn weigh(&mut self, friction: f64, mass: f64) {
        let usual = mass * quantile(&self.a_std, 0.5);
        let floor = self.noise.force.max(usual).max(NEGLIGIBLE * spread(&self.raw.force)).max(1e-300);
        for i in 0..self.mask.len() {
            let direction = friction * self.unknown[i];
            let jerk = (mass * self.a_std[i] - usual).max(0.0);
            self.mask[i] =
                1.0 / (1.0 + (direction / (TOLERATED * floor)).powi(2) + (jerk / (3.0 * floor)).powi(2));
        }
        let n = self.mask.len();
        for i in 0..self.filter.settle().min(n / 4) {
            self.mask[i] = 0.0;
            self.mask[n - 1 - i] = 0.0;
        }
        self.join();
    }

    /// Takes the smoothed acceleration near samples that are not used, rising and falling over as long as an edge of the
    /// filtered one swings.
    fn join(&mut self) {
        let width = (0.75 / (self.filter.cutoff() * self.raw.dt)).ceil();
        let mut since = f64::INFINITY;
        let run = |since: &mut f64, mask: f64| {
            *since = if mask < 0.5 { 0.0 } else { *since + 1.0 };
            *since
        };
        let mut nearest: Vec<f64> = self.mask.iter().map(|m| run(&mut since, *m)).collect();
        since = f64::INFINITY;
        for (near, mask) in nearest.iter_mut().zip(&self.mask).rev() {
            *near = near.min(run(&mut since, *mask));
        }
        for ((a, smoothed), near) in self.a.iter_mut().zip(&self.smoothed).zip(nearest) {
            let share = 0.5 - 0.5 * (PI * (near / (2.0 * width)).min(1.0)).cos();
            *a = share * *a + (1.0 - share) * smoothed;
        }
    }

    /// Weighs the samples as another track of the same motion.
    pub fn weigh_like(&mut self, other: &Self) {
        self.mask.clone_from(&other.mask);
        self.join();
    }

    fn measure_reversals(&mut self) {
        let (mut distance, mut since) = (f64::INFINITY, f64::INFINITY);
        for i in 1..self.x.len() {
            if self.sign[i] != self.sign[i - 1] {
                (distance, since) = (0.0, 0.0);
            } else {
                distance += (self.x[i] - self.x[i - 1]).abs();
                since += self.raw.dt;
            }
            self.distance[i] = distance;
            self.since[i] = since;
        }
        if let Some(d) = self.distance.first_mut() {
            *d = f64::INFINITY;
        }
        if let Some(s) = self.since.first_mut() {
            *s = f64::INFINITY;
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Time of sample `i`, s.
    pub fn time(&self, i: usize) -> f64 {
        self.raw.start + i as f64 * self.raw.dt
    }

    /// Number of rows the stretch gives.
    pub fn row_count(&self) -> usize {
        self.len() / self.stride
    }

    /// A series behind the filter. Linear: what holds of the samples holds of the result.
    pub fn pass(&self, series: &[f64]) -> Vec<f64> {
        let weighted: Vec<f64> = series.iter().zip(&self.mask).map(|(x, m)| x * m).collect();
        self.filter.apply(&weighted)
    }

    /// Weighted averages over `stride` samples of a series that is already behind the filter.
    pub fn rows(&self, series: &[f64], out: &mut Vec<f64>) {
        let share = 1.0 / self.stride as f64;
        for r in 0..self.row_count() {
            let from = r * self.stride;
            let sum: f64 = (from..from + self.stride).map(|i| series[i] * self.mask[i]).sum();
            out.push(sum * share);
        }
    }

    /// [`Self::pass`] and [`Self::rows`] of several series at once, each onto its own column.
    pub fn passed_rows<const L: usize>(&self, series: &[[f64; L]], out: &mut [Vec<f64>]) {
        let weighted: Vec<[f64; L]> = series.iter().zip(&self.mask).map(|(x, m)| x.map(|x| x * m)).collect();
        let filtered = self.filter.apply_lanes(&weighted);
        let share = 1.0 / self.stride as f64;
        for (samples, mask) in filtered.chunks_exact(self.stride).zip(self.mask.chunks_exact(self.stride)) {
            let mut sum = [0.0; L];
            for (x, m) in samples.iter().zip(mask) {
                for (s, x) in sum.iter_mut().zip(x) {
                    *s += x * m;
                }
            }
            for (column, s) in out.iter_mut().zip(sum) {
                column.push(s * share);
            }
        }
    }

    /// Unfiltered columns of the baseline: mass, Coulomb and viscous force for either direction.
    pub fn baseline(&self) -> [Vec<f64>; 5] {
        let n = self.len();
        let by = |way: f64, viscous: bool| -> Vec<f64> {
            // probability of that direction
            let share = |i: usize| 0.5 * (1.0 + way * self.direction[i]);
            (0..n).map(|i| share(i) * if viscous { self.v[i] } else { way }).collect()
        };
        [self.a.clone(), by(1.0, false), by(-1.0, false), by(1.0, true), by(-1.0, true)]
    }
}

/// Parts of a stretch that must each advance, and by how many times the noise of a position.
const PARTS: usize = 32;
const ADVANCES: f64 = 5.0;

/// The direction in which the body advances in every part of the recordings.
pub fn one_way(stretches: &[Channels]) -> Option<f64> {
    let part = stretches.iter().map(|s| s.position.len()).sum::<usize>().div_ceil(PARTS).max(4);
    let mut ways = stretches.iter().flat_map(|s| {
        let least = ADVANCES * noise_std(&s.position);
        // shorter parts tell too little to be asked
        s.position.chunks(part).filter(move |c| 2 * c.len() > part).map(move |c| {
            let by = c[c.len() - 1] - c[0];
            let range = c.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |r, x| (r.0.min(*x), r.1.max(*x)));
            // a part that comes back on the way does not only advance
            if by.abs() > least && range.1 - range.0 < by.abs() + least { by.signum() } else { 0.0 }
        })
    });
    let first = ways.next().filter(|w| *w != 0.0)?;
    ways.all(|w| w == first).then_some(first)
}
