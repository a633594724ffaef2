//! One gap-free stretch of a recording, filtered once and ready for regressors.
//!
//! Samples at which the sliding direction is not known are set aside *before* the filter's average is formed,
//! on both sides of the equation alike ([`Track::pass`]). A stuck body's friction is whatever balances the applied
//! force: such samples would be a mismatch for every law and information for none, and set aside behind the filter
//! they would have leaked into their neighbours already.
//!
//! For that the derivatives have to be sharper than the filter: they are taken behind a filter of
//! [`SHARPER`] times the cut-off, and the noise this lets through is taken out again by the filter itself.

use crate::signal::{LowPass, derivative, local_noise, quantile, rms};
use std::cell::LazyCell;
use std::f64::consts::PI;

/// Cut-off of the filter behind which derivatives are taken, in cut-offs.
const SHARPER: f64 = 3.0;

/// Raw channels of one gap-free stretch at one rate.
#[derive(Debug, Clone, Default)]
pub struct Channels {
    /// Index of the recording the stretch belongs to.
    pub recording: usize,
    /// Sample period, s.
    pub dt: f64,
    /// Time of the first sample, s.
    pub start: f64,
    /// Position, m or rad.
    pub position: Vec<f64>,
    /// Measured velocity, where the recording has one that is to be trusted.
    pub velocity: Option<Vec<f64>>,
    /// Measured acceleration, likewise.
    pub acceleration: Option<Vec<f64>>,
    /// Force, N or N·m.
    pub force: Vec<f64>,
    /// Normal load.
    pub normal: Option<Vec<f64>>,
    /// Δv of the baseline: speeds below it belong to its static branch, whose force is whatever balances. 0 where the
    /// recording shows no such band.
    pub static_band: f64,
    /// The body reverses so often that nothing would be left without the moments around reversals: they are kept.
    pub quick: bool,
    /// What the motion was asked to be, for finding its period.
    pub reference: Option<Vec<f64>>,
}

/// Standard deviation of the white noise of each channel, and of what is derived behind the filter.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Noise {
    /// Of a raw position sample.
    pub position: f64,
    /// Of a raw force sample.
    pub force: f64,
    /// Of the velocity of a track.
    pub velocity: f64,
    /// Of the acceleration behind the filter.
    pub acceleration: f64,
}

/// The stretch behind the filter.
#[derive(Debug, Clone)]
pub struct Track {
    /// The raw channels.
    pub raw: Channels,
    /// The filter.
    pub filter: LowPass,
    /// Position behind the sharper filter.
    pub x: Vec<f64>,
    /// Velocity behind the sharper filter.
    pub v: Vec<f64>,
    /// Acceleration behind the sharper filter.
    pub a: Vec<f64>,
    /// Force behind the sharper filter.
    pub f: Vec<f64>,
    /// Normal load behind the filter.
    pub normal: Option<Vec<f64>>,
    /// Sliding direction: −1 or 1.
    pub sign: Vec<f64>,
    /// 0 where the body may be stuck or the filter has not settled, 1 where it slides, smooth between.
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

/// Sum of squares one white sample of unit variance leaves behind a low-pass at `cutoff` after `order`
/// differentiations, in the small-band approximation.
pub fn differentiated(order: i32, cutoff: f64, dt: f64) -> f64 {
    let w = 2.0 * PI * cutoff;
    (w.powi(2 * order) * 2.0 * cutoff * dt / f64::from(2 * order + 1)).sqrt()
}

/// Noise of velocity and acceleration behind a low-pass at `cutoff`, every source of either used by its
/// weight.
pub fn derived_noise(channels: &Channels, cutoff: f64) -> Noise {
    let dt = channels.dt;
    let position = local_noise(&channels.position);
    let column = |c: &Option<Vec<f64>>| c.as_ref().map(|c| local_noise(c).max(1e-300));
    let parallel = |sources: &[Option<f64>]| {
        let information: f64 = sources.iter().flatten().map(|s| 1.0 / (s * s).max(1e-300)).sum();
        if information > 0.0 { information.sqrt().recip() } else { 0.0 }
    };
    let velocity_column = column(&channels.velocity);
    let acceleration_column = column(&channels.acceleration);
    Noise {
        position,
        force: local_noise(&channels.force),
        velocity: parallel(&[
            Some(position * differentiated(1, cutoff, dt)),
            velocity_column.map(|s| s * differentiated(0, cutoff, dt)),
        ]),
        acceleration: parallel(&[
            Some(position * differentiated(2, cutoff, dt)),
            velocity_column.map(|s| s * differentiated(1, cutoff, dt)),
            acceleration_column.map(|s| s * differentiated(0, cutoff, dt)),
        ]),
    }
}

/// Weights of sources by their noise, summing to one.
fn weights(noise: &[f64]) -> Vec<f64> {
    let information: Vec<f64> = noise.iter().map(|s| 1.0 / (s * s).max(1e-300)).collect();
    let sum: f64 = information.iter().sum();
    information.iter().map(|i| i / sum).collect()
}

fn combine(sources: &[(Vec<f64>, f64)]) -> Vec<f64> {
    let w = weights(&sources.iter().map(|s| s.1).collect::<Vec<_>>());
    let mut out = vec![0.0; sources[0].0.len()];
    for ((series, _), w) in sources.iter().zip(w) {
        for (o, s) in out.iter_mut().zip(series) {
            *o += w * s;
        }
    }
    out
}

impl Track {
    /// Filters the channels at `cutoff` Hz and finds where the sliding direction is known.
    pub fn new(raw: Channels, cutoff: f64) -> Self {
        let dt = raw.dt;
        let filter = LowPass::new(cutoff, dt);
        let sharper = (SHARPER * cutoff).min(0.3 / dt);
        let sharp = LowPass::new(sharper, dt);
        let noise = Noise { velocity: derived_noise(&raw, sharper).velocity, ..derived_noise(&raw, cutoff) };
        let x = sharp.apply(&raw.position);
        let f = sharp.apply(&raw.force);
        let slope = derivative(&x, dt);

        let mut velocities = vec![(slope.clone(), noise.position * differentiated(1, sharper, dt))];
        if let Some(column) = &raw.velocity {
            velocities.push((sharp.apply(column), local_noise(column) * differentiated(0, sharper, dt)));
        }
        let v = combine(&velocities);
        let mut accelerations =
            vec![(derivative(&slope, dt), noise.position * differentiated(2, cutoff, dt))];
        if let Some(column) = &raw.velocity {
            let a = derivative(&sharp.apply(column), dt);
            accelerations.push((a, local_noise(column) * differentiated(1, cutoff, dt)));
        }
        if let Some(column) = &raw.acceleration {
            accelerations.push((sharp.apply(column), local_noise(column) * differentiated(0, cutoff, dt)));
        }
        let a = combine(&accelerations);

        let n = x.len();
        let settle = filter.settle().min(n / 4);
        let stride = ((1.0 / dt) / (2.5 * cutoff)).round().max(1.0) as usize;
        let normal = raw.normal.as_ref().map(|c| filter.apply(c));
        let mut track = Self {
            filter,
            x,
            v,
            a,
            normal,
            force_model: f.clone(),
            f,
            sign: vec![1.0; n],
            mask: vec![1.0; n],
            distance: vec![0.0; n],
            since: vec![0.0; n],
            stride,
            noise,
            raw,
        };
        track.find_directions(sharper);
        for i in 0..settle {
            track.mask[i] = 0.0;
            track.mask[n - 1 - i] = 0.0;
        }
        track.soften((0.75 / (cutoff * dt)).ceil() as usize);
        track.measure_reversals();
        track
    }

    /// Velocity below which the direction is not known.
    pub fn guard(&self) -> f64 {
        let fast = quantile(&self.v.iter().map(|v| v.abs()).collect::<Vec<_>>(), 0.95);
        (3.0 * self.noise.velocity).max(0.003 * fast).max(self.raw.static_band)
    }

    /// `sharper` is the cut-off behind which the velocity was taken, Hz.
    fn find_directions(&mut self, sharper: f64) {
        let n = self.v.len();
        let dt = self.raw.dt;
        let guard = self.guard();
        // as far as an edge of the velocity is smeared
        let ring = (0.75 / (sharper * dt)).ceil() as usize;
        let mean = moving_mean(&self.v, ring);
        let mut unknown = Vec::new();
        let mut i = 0;
        let mut direction = self.v.iter().find(|v| v.abs() >= guard).map_or(1.0, |v| v.signum());
        while i < n {
            if self.v[i].abs() >= guard {
                // a reversal so swift that no sample falls into it is still somewhere between two of them
                if self.v[i].signum() != direction {
                    unknown.push((i.saturating_sub(ring), (i + ring).min(n)));
                }
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
            // Averaged, the noise of a body at rest stays below half the guard, and what slides slowly does not.
            let slowest = mean[start..i].iter().fold(f64::INFINITY, |m, v| m.min(v.abs()));
            // The most likely moment of the crossing is the last change of sign inside.
            let change =
                (start.max(1)..i).rev().find(|&j| self.v[j] * after > 0.0 && self.v[j - 1] * after <= 0.0);
            let change = change.unwrap_or((start + i) / 2).clamp(start, i);
            for j in start..i {
                self.sign[j] = if j < change { direction } else { after };
            }
            // A reversal, a rest, or the static branch. A moment's error at a reversal is twice the Coulomb force for that moment.
            if after != direction || self.raw.static_band > 0.0 || slowest < 0.5 * guard {
                unknown.push((start.saturating_sub(ring), (i + ring).min(n)));
            }
            direction = after;
        }
        for (from, to) in unknown.into_iter().filter(|_| !self.raw.quick) {
            self.mask[from..to].fill(0.0);
        }
    }

    /// Lets the mask rise over `width` samples beside every gap. An edge of the acceleration is smeared by the sharper
    /// filter; cut through by a hard mask it would not cancel.
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

    /// A series with what is set aside taken out, behind the filter. Linear: what holds of the samples in use holds
    /// of the result.
    pub fn pass(&self, series: &[f64]) -> Vec<f64> {
        let masked: Vec<f64> = series.iter().zip(&self.mask).map(|(x, m)| x * m).collect();
        self.filter.apply(&masked)
    }

    /// Masked averages over `stride` samples of a series that is already behind the filter.
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
        let masked: Vec<[f64; L]> = series.iter().zip(&self.mask).map(|(x, m)| x.map(|x| x * m)).collect();
        let filtered = self.filter.apply_lanes(&masked);
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
        let by = |forward: bool, viscous: bool| -> Vec<f64> {
            let want = if forward { 1.0 } else { -1.0 };
            (0..n)
                .map(|i| {
                    if self.sign[i] != want {
                        0.0
                    } else if viscous {
                        self.v[i]
                    } else {
                        want
                    }
                })
                .collect()
        };
        [self.a.clone(), by(true, false), by(false, false), by(true, true), by(false, true)]
    }
}

/// The cut-off for a set of stretches: as high as the channels' noise allows, so that what happens at a
/// reversal stays visible, and no higher than an eighth of the rate.
///
/// Limited by the noise that differentiating the position puts on the inertial force, which must not exceed
/// the force channel's own noise, or half a percent of the force.
pub fn choose_cutoff(stretches: &[Channels]) -> f64 {
    let slowest = stretches.iter().map(|c| 1.0 / c.dt).fold(f64::INFINITY, f64::min);
    let ceiling = slowest / 8.0;
    let motion = stretches.iter().map(dominant_frequency).fold(0.0, f64::max);
    let lowest = (8.0 * motion).min(ceiling);
    let mass = stretches.iter().map(|c| rough_mass(c, (10.0 * motion).min(ceiling))).fold(0.0, f64::max);
    let fits = |cutoff: f64| {
        stretches.iter().all(|c| {
            let noise = derived_noise(c, cutoff);
            let force = (noise.force * differentiated(0, cutoff, c.dt)).max(0.005 * deviation(&c.force));
            mass * noise.acceleration <= force
        })
    };
    let mut cutoff = ceiling.min(150.0);
    while cutoff > lowest && !fits(cutoff) {
        cutoff *= 0.85;
    }
    cutoff.max(lowest).min(ceiling)
}

/// Longest average over which a position is looked at as a motion, s, unless its noise asks for a longer one.
const COARSE: f64 = 0.05;

/// Frequency of a sine with the same ratio of velocity to position, Hz.
pub fn dominant_frequency(channels: &Channels) -> f64 {
    let (n, dt) = (channels.position.len(), channels.dt);
    let noise = LazyCell::new(|| local_noise(&channels.position));
    let coarse = |step: usize| -> Vec<f64> {
        channels.position.chunks(step).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect()
    };
    let speed = |step: usize| rms(&derivative(&coarse(step), step as f64 * dt));
    let of_noise = |step: usize| *noise / ((2 * step) as f64).sqrt() / (step as f64 * dt);
    // A coarse derivative, so that noise does not count as motion, but not over whole strokes of a long recording.
    let coarsest = (n / 400).max(1);
    let mut step = ((COARSE / dt) as usize).clamp(1, coarsest);
    while 2 * step <= coarsest && of_noise(step) > 0.1 * speed(step) {
        step *= 2;
    }
    let size = deviation(&coarse(step));
    if size > 0.0 { speed(step) / (2.0 * PI * size) } else { 0.0 }
}

/// Mean over `half` samples to either side, fewer at the ends.
fn moving_mean(series: &[f64], half: usize) -> Vec<f64> {
    let mut sums = vec![0.0; series.len() + 1];
    for (i, x) in series.iter().enumerate() {
        sums[i + 1] = sums[i] + x;
    }
    (0..series.len())
        .map(|i| {
            let (low, high) = (i.saturating_sub(half), (i + half + 1).min(series.len()));
            (sums[high] - sums[low]) / (high - low) as f64
        })
        .collect()
}

fn deviation(series: &[f64]) -> f64 {
    let mean = series.iter().sum::<f64>() / series.len().max(1) as f64;
    rms(&series.iter().map(|x| x - mean).collect::<Vec<_>>())
}

fn rough_mass(channels: &Channels, cutoff: f64) -> f64 {
    let filter = LowPass::new(cutoff.max(1e-6), channels.dt);
    let x = filter.apply(&channels.position);
    let v = derivative(&x, channels.dt);
    let a = derivative(&v, channels.dt);
    let sign: Vec<f64> =
        filter.apply(&v.iter().map(|v| if *v < 0.0 { -1.0 } else { 1.0 }).collect::<Vec<_>>());
    let f = filter.apply(&channels.force);
    let basis = crate::linear::Basis::of(&[&v[..], &sign[..], &vec![1.0; v.len()][..]]);
    let (a, f) = (basis.project_out(&a), basis.project_out(&f));
    let power = crate::linear::dot(&a, &a);
    if power > 0.0 { (crate::linear::dot(&a, &f) / power).abs() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_recording_was_averaged_over_whole_strokes() {
        for (samples, hz) in [(16_000, 0.8), (1_000_000, 0.8), (1_000_000, 0.002)] {
            let noise = |i: usize| 1e-6 * ((i * 7_919 % 1_009) as f64 / 1_009.0 - 0.5);
            let at = |i: usize| 8e-3 * (2.0 * PI * hz * i as f64 * 1e-3).sin() + noise(i);
            let channels =
                Channels { dt: 1e-3, position: (0..samples).map(at).collect(), ..Channels::default() };
            let found = dominant_frequency(&channels);
            println!("{samples} samples at {hz} Hz: {found:.4} Hz");
            assert!((found / hz - 1.0).abs() < 0.05, "{found}");
        }
    }
}
