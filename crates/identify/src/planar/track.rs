//! One gap-free stretch of a recording in the plane behind the filter, with what is known of its direction of motion.
//!
//! As on a line, samples at which the direction is not known are set aside before the filter's average is formed, on both
//! sides of the equation alike: friction of a body at rest is whatever balances the applied force.

use signals::{Channels, LowPass, central_difference, derived_noise, differentiated, noise_std, quantile};
use std::f64::consts::PI;

/// Cut-off of the filter behind which derivatives are taken, in cut-offs.
const SHARPER: f64 = 3.0;
/// Speeds below this many standard deviations of the velocity's noise have no direction.
const DIRECTED: f64 = 6.0;
/// Speeds below this share of the fast ones count as rest.
const SLOW: f64 = 0.01;
/// Cosine of the largest turn that the filter may smear, from one side of its ring to the other.
const TURN: f64 = 0.3;

/// The stretch, both axes at once.
#[derive(Debug, Clone)]
pub struct Track {
    /// The channels it was made of.
    pub raw: [Channels; 2],
    /// The filter.
    pub filter: LowPass,
    /// Position behind the sharper filter, m.
    pub x: [Vec<f64>; 2],
    /// Velocity behind the sharper filter, m/s.
    pub v: [Vec<f64>; 2],
    /// Acceleration behind the sharper filter, m/s².
    pub a: [Vec<f64>; 2],
    /// Force behind the sharper filter, N.
    pub f: [Vec<f64>; 2],
    /// Speed, m/s.
    pub speed: Vec<f64>,
    /// Direction of the motion, a unit vector.
    pub direction: [Vec<f64>; 2],
    /// 0 where the direction is not known or the filter has not settled, 1 where the body slides, smooth between.
    pub mask: Vec<f64>,
    /// Samples averaged into one row.
    pub stride: usize,
    /// Speed below which the direction is not known, m/s.
    pub guard: f64,
    /// Standard deviation of the noise of each acceleration behind the filter, m/s².
    pub acceleration_noise: [f64; 2],
}

/// Sum of two sources weighted by their noise.
fn combined(one: Vec<f64>, of_one: f64, other: Option<(Vec<f64>, f64)>) -> Vec<f64> {
    let Some((other, of_other)) = other else { return one };
    let (a, b) = (1.0 / (of_one * of_one).max(1e-300), 1.0 / (of_other * of_other).max(1e-300));
    one.iter().zip(&other).map(|(x, y)| (a * x + b * y) / (a + b)).collect()
}

/// Position, velocity and acceleration of an axis behind the sharper filter.
fn motion(raw: &Channels, sharp: &LowPass, sharper: f64, cutoff: f64) -> [Vec<f64>; 3] {
    let dt = raw.dt;
    let x = sharp.apply(&raw.position);
    let slope = central_difference(&x, dt);
    let of_position = noise_std(&raw.position);
    let column = |c: &Option<Vec<f64>>| c.as_ref().map(|c| (sharp.apply(c), noise_std(c)));
    let velocity = column(&raw.velocity);
    let quick = velocity.clone().map(|(v, noise)| (v, noise * differentiated(0, sharper, dt)));
    let v = combined(slope.clone(), of_position * differentiated(1, sharper, dt), quick);
    let bent = velocity.map(|(v, noise)| (central_difference(&v, dt), noise * differentiated(1, cutoff, dt)));
    let by_motion = match bent {
        // of two sources of one motion the quieter; the accelerometer is beside both
        Some((a, noise)) if noise < of_position * differentiated(2, cutoff, dt) => (a, noise),
        _ => (central_difference(&slope, dt), of_position * differentiated(2, cutoff, dt)),
    };
    let shown = column(&raw.acceleration).map(|(a, noise)| (a, noise * differentiated(0, cutoff, dt)));
    let a = combined(by_motion.0, by_motion.1, shown);
    [x, v, a]
}

impl Track {
    /// Filters both axes at `cutoff` Hz and finds where the direction is known.
    #[must_use]
    pub fn new(raw: [Channels; 2], cutoff: f64) -> Self {
        let dt = raw[0].dt;
        let filter = LowPass::new(cutoff, dt);
        let sharper = (SHARPER * cutoff).min(0.3 / dt);
        let sharp = LowPass::new(sharper, dt);
        let [[px, vx, ax], [py, vy, ay]] = [&raw[0], &raw[1]].map(|c| motion(c, &sharp, sharper, cutoff));
        let speed: Vec<f64> = vx.iter().zip(&vy).map(|(x, y)| x.hypot(*y)).collect();
        let of = |v: &[f64]| v.iter().zip(&speed).map(|(v, s)| v / s.max(1e-300)).collect::<Vec<_>>();
        let direction = [of(&vx), of(&vy)];
        let noise = |cutoff: f64| [&raw[0], &raw[1]].map(|c| derived_noise(c, cutoff));
        let slow = noise(sharper).map(|n| n.velocity).into_iter().fold(0.0, f64::max);
        let guard = (DIRECTED * slow).max(SLOW * quantile(&speed, 0.95));
        let n = speed.len();
        let mut track = Self {
            f: [sharp.apply(&raw[0].force), sharp.apply(&raw[1].force)],
            acceleration_noise: noise(cutoff).map(|n| n.acceleration),
            filter,
            x: [px, py],
            v: [vx, vy],
            a: [ax, ay],
            speed,
            direction,
            mask: vec![1.0; n],
            stride: ((1.0 / dt) / (2.5 * cutoff)).round().max(1.0) as usize,
            guard,
            raw,
        };
        // as far as an edge of the velocity is smeared
        let ring = (0.75 / (sharper * dt)).ceil() as usize;
        let unknown: Vec<bool> = (0..n).map(|i| track.is_unknown(i, ring)).collect();
        for i in (0..n).filter(|i| unknown[*i]) {
            track.mask[i.saturating_sub(ring)..(i + ring + 1).min(n)].fill(0.0);
        }
        let settle = filter.settle().min(n / 4);
        track.mask[..settle].fill(0.0);
        track.mask[n - settle..].fill(0.0);
        track.soften((0.75 / (cutoff * dt)).ceil() as usize);
        track
    }

    /// Too slow, or turning faster than the filter shows.
    fn is_unknown(&self, i: usize, ring: usize) -> bool {
        if self.speed[i] < self.guard {
            return true;
        }
        let (low, high) = (i.saturating_sub(ring), (i + ring).min(self.len() - 1));
        let [x, y] = &self.direction;
        x[low] * x[high] + y[low] * y[high] < TURN
    }

    /// Lets the mask rise over `width` samples beside every gap: an edge smeared by the sharper filter and cut through by a
    /// hard mask would not cancel.
    fn soften(&mut self, width: usize) {
        let run = |since: &mut usize, mask: f64| {
            *since = if mask == 0.0 { 0 } else { since.saturating_add(1) };
            *since
        };
        let mut since = usize::MAX;
        let mut nearest: Vec<usize> = self.mask.iter().map(|m| run(&mut since, *m)).collect();
        since = usize::MAX;
        for (near, m) in nearest.iter_mut().zip(&self.mask).rev() {
            *near = (*near).min(run(&mut since, *m));
        }
        for (m, near) in self.mask.iter_mut().zip(nearest) {
            if near <= width {
                *m = 0.5 - 0.5 * (PI * near as f64 / (width + 1) as f64).cos();
            }
        }
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.speed.len()
    }

    /// No samples at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.speed.is_empty()
    }

    /// Number of rows of one axis.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.len() / self.stride
    }

    /// Time of the middle of row `r`, s.
    #[must_use]
    pub fn row_time(&self, r: usize) -> f64 {
        self.raw[0].start
            + (r * self.stride) as f64 * self.raw[0].dt
            + 0.5 * (self.stride - 1) as f64 * self.raw[0].dt
    }

    /// Rows of a series of one axis: what is set aside taken out, behind the filter, averaged over `stride` samples.
    #[must_use]
    pub fn rows(&self, series: &[f64]) -> Vec<f64> {
        let masked: Vec<f64> = series.iter().zip(&self.mask).map(|(x, m)| x * m).collect();
        let passed = self.filter.apply(&masked);
        let mean = |r: usize| {
            let samples = r * self.stride..(r + 1) * self.stride;
            samples.map(|i| passed[i] * self.mask[i]).sum::<f64>() / self.stride as f64
        };
        (0..self.row_count()).map(mean).collect()
    }

    /// Share of each row's squares that is used.
    #[must_use]
    pub fn share(&self) -> Vec<f64> {
        self.rows(&vec![1.0; self.len()]).iter().map(|s| s * s).collect()
    }

    /// Mean over the used samples of each row; NaN where none is.
    #[must_use]
    pub fn row_means(&self, series: &[f64]) -> Vec<f64> {
        let mean = |r: usize| {
            let samples = r * self.stride..(r + 1) * self.stride;
            let (sum, weight) =
                samples.fold((0.0, 0.0), |(s, w), i| (s + series[i] * self.mask[i], w + self.mask[i]));
            if weight > 0.0 { sum / weight } else { f64::NAN }
        };
        (0..self.row_count()).map(mean).collect()
    }
}
