//! Static friction and Δv from the samples in which the handle leaves rest, band by band.
//!
//! Below Δv they are held back by D, above by the sliding law, and the band that holds Δv by a mixture of both. Every
//! Δv has a likelihood by that; its mean and spread are the estimate. A band is wider than what this resolves.
//!
//! Where Δv is in the first band, half of it with twice the step explains the same mean. What is known of friction
//! beforehand decides: static friction exceeds sliding by some half of it, rarely by twice that.

use super::fit::Fit;
use super::identified::Estimate;
use super::moments::Departures;
use super::recorder::{BANDS, MOVING};
use core::f32::consts::{SQRT_2, TAU};
use friction::Scalar;

/// Bands in which static friction is looked for.
const SLOW_BANDS: usize = BANDS - 1;
/// Speeds a band is divided into.
const STEPS: usize = 4;
const SPEEDS: usize = SLOW_BANDS * STEPS;
/// What a step must explain, in variances of a sample: chance explains 2·ln(44), and 12 more is 3.5 standard errors.
const CHANCE: f32 = 19.6;
/// Scale of the excess of static over sliding friction that is expected beforehand, as a share of sliding friction.
const EXPECTED: f32 = 0.5;
/// Standard deviation of a uniform variable of width 1.
pub(super) const UNIFORM: f32 = 0.288_675;

/// Δv, and D of both directions where there are samples that tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BreakAway {
    pub delta_v: Estimate,
    pub levels: [Option<Estimate>; 2],
}

/// A band in one direction: samples, their mean friction and its excess over the sliding law, N.
#[derive(Debug, Clone, Copy, Default)]
struct Band {
    n: f32,
    friction: f32,
    excess: f32,
}

/// What is known of D if Δv is this.
#[derive(Debug, Clone, Copy, Default)]
struct Level {
    level: f32,
    /// Samples it is known from.
    n: f32,
    /// Squares it explains, N².
    explained: f32,
}

/// Share of the samples of band `k` below `edge` bands. Those of the first are surely not at rest, so none of them is
/// slower than a quarter of it.
fn share(k: usize, edge: f32) -> f32 {
    let begin = if k == 0 { MOVING } else { 0.0 };
    Scalar::clamp((edge - k as f32 - begin) / (1.0 - begin), 0.0, 1.0)
}

fn edge_of(index: usize) -> f32 {
    (index as f32 + 0.5) / STEPS as f32
}

fn level(bands: &[Band], edge: f32) -> Level {
    let (mut n, mut sum, mut above) = (0.0, 0.0, 0.0);
    for (k, band) in bands.iter().enumerate() {
        let p = share(k, edge);
        let sliding = band.friction - band.excess;
        n += band.n * p * p;
        sum += band.n * p * (band.friction - (1.0 - p) * sliding);
        above += band.n * p * band.excess;
    }
    // a static level below the sliding law is none
    if !(n > 0.0 && above > 0.0) {
        return Level::default();
    }
    let level = sum / n;
    let mut explained = 0.0;
    for (k, band) in bands.iter().enumerate() {
        let p = share(k, edge);
        let left = band.excess - p * (level - (band.friction - band.excess));
        explained += band.n * (band.excess * band.excess - left * left);
    }
    Level { level, n, explained }
}

impl BreakAway {
    /// `None`: no step stands out of the noise. `width` is that of a band, m/s; `period` s.
    pub fn find(departures: &[[Departures; 2]], fit: &Fit, width: f32, period: f32) -> Option<Self> {
        let mut ways = [[Band::default(); SLOW_BANDS]; 2];
        for (way, (bands, sign)) in ways.iter_mut().zip([1.0, -1.0]).enumerate() {
            for (k, (band, there)) in bands.iter_mut().zip(departures).enumerate() {
                let Some(there) = there.get(way) else { continue };
                let friction = sign * (there.load - fit.mass.value * fit.accelerometer.of(there.reading));
                let sliding = fit.sliding(way, (k as f32 + 0.5) * width);
                *band = Band { n: there.count as f32, friction, excess: friction - sliding };
            }
        }
        let noise = fit.noise_by_accelerometer;
        let mut scores = [0.0; SPEEDS];
        let (mut gain, mut highest) = (0.0, f32::MIN);
        for (index, score) in scores.iter_mut().enumerate() {
            let mut explained = 0.0;
            for (bands, coulomb) in ways.iter().zip(&fit.coulomb) {
                let found = level(bands, edge_of(index));
                if found.n > 0.0 {
                    let expected = Scalar::max(EXPECTED * coulomb.value, Scalar::sqrt(noise));
                    explained += found.explained;
                    // a level costs what it could have been and is not
                    *score -= 0.5 * Scalar::ln(1.0 + found.n * expected * expected / (TAU * noise))
                        + Scalar::max(found.level - coulomb.value, 0.0) / expected;
                }
            }
            *score += 0.5 * explained / noise;
            gain = Scalar::max(gain, explained);
            highest = Scalar::max(highest, *score);
        }
        if !(gain >= CHANCE * noise) {
            return None;
        }
        let mut speed = Weighted::default();
        let mut levels = [Weighted::default(); 2];
        let mut samples = [Weighted::default(); 2];
        for (index, score) in scores.iter().enumerate() {
            let weight = Scalar::exp(*score - highest);
            speed.add(weight, edge_of(index) * width);
            for ((bands, level_sums), n) in ways.iter().zip(&mut levels).zip(&mut samples) {
                let found = level(bands, edge_of(index));
                if found.n > 0.0 {
                    level_sums.add(weight, found.level);
                    n.add(weight, found.n);
                }
            }
        }
        let edge = speed.mean() / width;
        let gap = gap(departures, fit, edge) * period;
        let gap = if gap > 0.0 { Scalar::min(gap, width) } else { width };
        // Δv is somewhere between two samples, which are somewhere in their band
        let resolution = SQRT_2 * UNIFORM * Scalar::max(gap, width / STEPS as f32);
        let mut out = Self {
            delta_v: Estimate {
                value: speed.mean(),
                std: Scalar::sqrt(speed.variance() + resolution * resolution),
            },
            levels: [None; 2],
        };
        for ((out, level), n) in out.levels.iter_mut().zip(&levels).zip(&samples) {
            let n = n.mean();
            if n >= 2.0 {
                *out =
                    Some(Estimate { value: level.mean(), std: Scalar::sqrt(level.variance() + noise / n) });
            }
        }
        Some(out)
    }
}

/// Mean acceleration with which the handle passes `edge` bands, m/s²: times a period the gap between two samples. Past
/// Δv friction is lower and the gap wider, so the band above counts if it is faster. In a motion that repeats itself Δv
/// is in the same gap every time.
fn gap(departures: &[[Departures; 2]], fit: &Fit, edge: f32) -> f32 {
    let mean = |ways: &[Departures; 2]| {
        let (mut count, mut sum) = (0.0, 0.0);
        for (there, sign) in ways.iter().zip([1.0, -1.0]) {
            count += there.count as f32;
            sum += there.count as f32 * sign * fit.accelerometer.of(there.reading);
        }
        if count > 0.0 { sum / count } else { 0.0 }
    };
    departures.iter().skip(edge as usize).take(2).map(mean).fold(0.0, Scalar::max)
}

/// Mean and variance.
#[derive(Debug, Clone, Copy, Default)]
struct Weighted {
    weight: f32,
    sum: f32,
    squares: f32,
}

impl Weighted {
    fn add(&mut self, weight: f32, x: f32) {
        self.weight += weight;
        self.sum += weight * x;
        self.squares += weight * x * x;
    }

    fn mean(&self) -> f32 {
        if self.weight > 0.0 { self.sum / self.weight } else { 0.0 }
    }

    fn variance(&self) -> f32 {
        let mean = self.mean();
        if self.weight > 0.0 { Scalar::max(self.squares / self.weight - mean * mean, 0.0) } else { 0.0 }
    }
}
