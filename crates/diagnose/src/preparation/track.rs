//! One gap-free stretch of a recording, filtered once and ready for regressors.
//!
//! Samples at which the sliding direction is not known are set aside *before* the filter's average is formed,
//! on both sides of the equation alike ([`Track::pass`]). A stuck body's friction is whatever balances the applied
//! force: such samples would be a mismatch for every law and information for none, and set aside behind the filter
//! they would have leaked into their neighbours already.
//!
//! For that the derivatives have to be sharper than the filter: they are taken behind a filter of
//! [`SHARPER`] times the cut-off, and the noise this lets through is taken out again by the filter itself. A body that only
//! advances never stands still behind a filter that does not overshoot: there it is a [`Gaussian`], as a dip before each step
//! of the speed would be a fall of orders of magnitude for a law of its logarithm.

use crate::preparation::blows::{Unresolved, unresolved};
use signals::{
    Channels, Gaussian, LowPass, Noise, SHARPER, SMEARED, central_difference, derived_noise, differentiated,
    four_point_difference, noise_std, quantile, soften,
};

/// Cycles of a filter that are set aside beside a reversal of a body whose speed there is derived from its position, in place of
/// [`SMEARED`]. What is smeared farther than that the filter takes out: a third as sharp, it leaves a hundredth of it. A
/// measured velocity may be late and held, and no filter takes that out.
const DERIVED: f64 = 0.25;

/// Least speed beside a stop that is over before it shows in an average, and largest mean speed within it, in guards.
const QUICK: f64 = 4.0;
const STOPPED: f64 = 0.2;

/// Share of the samples that blows may set aside.
const MOST_BLOWS: f64 = 0.1;

/// Samples that the speed of a body that gets going is followed for at least.
const CURVE: usize = 4;

/// What is known of the moments at which the direction of sliding is not.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Reversals {
    /// Δv of the baseline: speeds below it belong to its static branch, whose force is whatever balances. 0 where the
    /// recording shows no such band.
    pub static_band: f64,
    /// The direction of a body that only ever advances: it is known at every sample, however slow.
    pub one_way: Option<f64>,
    /// As much is set aside beside a reversal whose speed is derived as beside one whose speed is measured.
    pub wide: bool,
    /// The body reverses so often that nothing would be left without the moments around reversals: they are kept.
    pub kept: bool,
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
    /// Samples beside blows that were over between two of them, which are set aside.
    pub blows: Vec<usize>,
    /// Samples averaged into one row.
    pub stride: usize,
    /// Noise of the channels.
    pub noise: Noise,
}

/// Least variance of a source, so that weight times value stays finite.
const FAINTEST: f64 = 1e-200;

/// A series with the standard deviation of its noise, and a further weight for each sample, from 0 to 1.
struct Source<'a> {
    series: Vec<f64>,
    std: f64,
    share: Option<&'a [f64]>,
}

/// The mean of the sources, weighted by their information.
fn combine(sources: &[Source]) -> Vec<f64> {
    let at = |i: usize| {
        let (sum, information) = sources.iter().fold((0.0, 0.0), |(sum, information), s| {
            let own = s.share.map_or(1.0, |share| share[i]) / (s.std * s.std).max(FAINTEST);
            (sum + own * s.series[i], information + own)
        });
        sum / information
    };
    (0..sources[0].series.len()).map(at).collect()
}

impl Track {
    /// Filters the channels at `cutoff` Hz and finds where the sliding direction is known.
    pub fn new(raw: Channels, cutoff: f64, reversals: Reversals) -> Self {
        let dt = raw.dt;
        let filter = LowPass::new(cutoff, dt);
        let sharper = (SHARPER * cutoff).min(0.3 / dt);
        let sharp = |series: &[f64]| match reversals.one_way {
            Some(_) => Gaussian::new(sharper, dt).apply(series),
            None => LowPass::new(sharper, dt).apply(series),
        };
        // The speed stays a difference of two points, which is quieter. An acceleration of two points loses a fifth at an eighth of the
        // rate. One of four overshoots beside a step of the speed, which a body that only advances must not.
        let rate = |series: &[f64]| match reversals.one_way {
            Some(_) => central_difference(series, dt),
            None => four_point_difference(series, dt),
        };
        let noise = Noise { velocity: derived_noise(&raw, sharper).velocity, ..derived_noise(&raw, cutoff) };
        let x = sharp(&raw.position);
        let f = sharp(&raw.force);
        let slope = central_difference(&x, dt);
        let behind = |std: f64, order: i32, cutoff: f64| std * differentiated(order, cutoff, dt);
        let in_time = raw.late_below.map(|below| in_time(&slope, below, samples(SMEARED, sharper, dt)));
        let share = in_time.as_deref();
        let source = |series: Vec<f64>, std: f64| Source { series, std, share: None };
        let mut accelerations = vec![source(rate(&rate(&x)), behind(noise.position, 2, cutoff))];
        let mut velocities = vec![source(slope, behind(noise.position, 1, sharper))];
        if let Some(column) = &raw.velocity {
            let (v, std) = (sharp(column), noise_std(column));
            accelerations.push(Source { series: rate(&v), std: behind(std, 1, cutoff), share });
            velocities.push(Source { series: v, std: behind(std, 0, sharper), share });
        }
        if let Some(column) = &raw.acceleration {
            accelerations.push(source(sharp(column), behind(noise_std(column), 0, cutoff)));
        }
        let (v, a) = (combine(&velocities), combine(&accelerations));

        let n = x.len();
        let settle = filter.settle().min(n / 4);
        let stride = stride(dt, cutoff);
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
            blows: Vec::new(),
            stride,
            noise,
            reversals,
            raw,
        };
        track.find_directions(sharper);
        let beside = samples(track.beside(), cutoff, dt);
        track.set_blows_aside(samples(SMEARED, sharper, dt));
        soften(&mut track.mask, beside);
        let mut ends = vec![1.0; n];
        ends[..settle].fill(0.0);
        ends[n - settle..].fill(0.0);
        soften(&mut ends, samples(SMEARED, cutoff, dt));
        for (mask, end) in track.mask.iter_mut().zip(ends) {
            *mask = mask.min(end);
        }
        track.measure_reversals();
        track
    }

    /// Sets what is `around` each blow aside, in samples. Where that is much of the motion, all of it is sampled as coarsely, and
    /// the noise floor has it.
    fn set_blows_aside(&mut self, around: usize) {
        // a body that only advances is given steps of the speed to see what follows them
        if self.reversals.one_way.is_some() {
            return;
        }
        let n = self.len();
        let beside = |i: usize| i.saturating_sub(around)..(i + around + 1).min(n);
        let Unresolved { force: mut blows, beyond_friction, motion } =
            unresolved(&self.raw, &self.noise, &self.a, self.filter.cutoff());
        // at a reversal the force jumps because friction changes sign
        blows.retain(|i| self.sign[beside(*i)].windows(2).all(|pair| pair[0] == pair[1]));
        blows.extend(beyond_friction.into_iter().chain(motion));
        let mut aside = vec![1.0; n];
        for &i in &blows {
            aside[beside(i)].fill(0.0);
        }
        if aside.iter().sum::<f64>() < (1.0 - MOST_BLOWS) * n as f64 {
            return;
        }
        self.blows = blows;
        for (mask, aside) in self.mask.iter_mut().zip(aside) {
            *mask = mask.min(aside);
        }
    }

    /// Velocity below which the direction is not known.
    pub fn guard(&self) -> f64 {
        let fast = quantile(&self.v.iter().map(|v| v.abs()).collect::<Vec<_>>(), 0.95);
        (3.0 * self.noise.velocity).max(0.003 * fast).max(self.reversals.static_band)
    }

    /// Cycles of a filter that are set aside beside a reversal.
    fn beside(&self) -> f64 {
        let measured = self.raw.velocity.is_some() && self.raw.late_below.is_none();
        if self.reversals.wide || measured { SMEARED } else { DERIVED }
    }

    /// `sharper` is the cut-off behind which the velocity was taken, Hz.
    fn find_directions(&mut self, sharper: f64) {
        if let Some(way) = self.reversals.one_way {
            self.sign.fill(way);
            return;
        }
        let n = self.v.len();
        let dt = self.raw.dt;
        let guard = self.guard();
        let ring = samples(self.beside(), sharper, dt);
        let window = samples(SMEARED, sharper, dt);
        let mean = moving_mean(&self.v, window);
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
            // The noise of a body that is held crosses zero long before it gets going. One that passes crossed where its sign changed.
            let begun = if after != direction { self.begins(start..i, guard) } else { None };
            let change = begun
                .or_else(|| {
                    (start.max(1)..i).rev().find(|&j| self.v[j] * after > 0.0 && self.v[j - 1] * after <= 0.0)
                })
                .unwrap_or((start + i) / 2)
                .clamp(start, i);
            for j in start..i {
                self.sign[j] = if j < change { direction } else { after };
            }
            // A reversal, a rest, or the static branch. A moment's error at a reversal is twice the Coulomb force for that moment.
            if after != direction
                || self.reversals.static_band > 0.0
                || slowest < 0.5 * guard
                || self.stops(start..i, window, guard)
            {
                unknown.push((start.saturating_sub(ring), (i + ring).min(n)));
            }
            direction = after;
        }
        for (from, to) in unknown.into_iter().filter(|_| !self.reversals.kept) {
            self.mask[from..to].fill(0.0);
        }
    }

    /// Whether a body stopped between quick motions, within twice the `window` of an average: too short for it to show there.
    fn stops(&self, slow: std::ops::Range<usize>, window: usize, guard: f64) -> bool {
        let quick =
            |at: Option<usize>| at.and_then(|at| self.v.get(at)).is_some_and(|v| v.abs() > QUICK * guard);
        let mean = self.v[slow.clone()].iter().sum::<f64>().abs() / slow.len() as f64;
        slow.len() <= 2 * window
            && quick(slow.start.checked_sub(window))
            && quick(Some(slow.end + window))
            && mean < STOPPED * guard
    }

    /// Sample at which a body got going that was held meanwhile: where the curve of its speed begins that fits best until this is well
    /// above the guard, for a cycle of the filter at most. None of a body that passed, in twice the time of its way out.
    fn begins(&self, slow: std::ops::Range<usize>, guard: f64) -> Option<usize> {
        let cycle = samples(1.0, self.filter.cutoff(), self.raw.dt);
        let gone = self.v[slow.end..].iter().take(cycle).position(|v| v.abs() >= 4.0 * guard);
        let to = slow.end + gone.unwrap_or(cycle).max(CURVE);
        // what is left of coming to rest is not looked at
        let from = slow.end - cycle.min(slow.len() / 2);
        let begun = from + get_going(self.v.get(from..to)?)?;
        (slow.len() > 3 * (slow.end - begun.min(slow.end)).max(1)).then_some(begun)
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
    pub fn passed_rows<const L: usize>(&self, mut series: Vec<[f64; L]>, out: &mut [Vec<f64>]) {
        for (x, m) in series.iter_mut().zip(&self.mask) {
            *x = x.map(|x| x * m);
        }
        let filtered = self.filter.apply_lanes(&series);
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

    /// What a delay of the force adds to it per second. Below a sample the first term of the shift is all there is of it.
    pub fn late(&self) -> Vec<f64> {
        four_point_difference(&self.f, self.raw.dt).iter().map(|rate| -rate).collect()
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

/// Weight of a velocity column that lags below a speed: 0 there, 1 from twice that speed on, and less within `around` samples of 0.
fn in_time(slope: &[f64], late_below: f64, around: usize) -> Vec<f64> {
    let by_speed: Vec<f64> = slope.iter().map(|v| (v.abs() / late_below - 1.0).clamp(0.0, 1.0)).collect();
    let mut beside = by_speed.clone();
    soften(&mut beside, around);
    beside.iter().zip(by_speed).map(|(a, b)| a.min(b)).collect()
}

/// Samples, `dt` seconds apart, in some cycles of a filter at `cutoff` Hz.
fn samples(cycles: f64, cutoff: f64, dt: f64) -> usize {
    (cycles / (cutoff * dt)).ceil() as usize
}

/// Samples, `dt` seconds apart, averaged into one row behind a filter at `cutoff` Hz.
pub fn stride(dt: f64, cutoff: f64) -> usize {
    ((1.0 / dt) / (2.5 * cutoff)).round().max(1.0) as usize
}

/// Sample from which a speed grows that was zero before, as a·τ + c·τ² with a and c of one sign: the moment of the least squares. None
/// where that is the first or the last.
fn get_going(speed: &[f64]) -> Option<usize> {
    // a quarter of a sample, coarser where the filter is slow beside the rate
    const FINEST: f64 = 0.25;
    const MOST: f64 = 200.0;
    let explained = |moment: f64| {
        let [mut tt, mut ttt, mut tttt, mut tv, mut ttv] = [0.0; 5];
        for (k, v) in speed.iter().enumerate().skip(moment.ceil() as usize) {
            let t = k as f64 - moment;
            (tt, ttt, tttt) = (tt + t * t, ttt + t * t * t, tttt + t * t * t * t);
            (tv, ttv) = (tv + t * v, ttv + t * t * v);
        }
        let one = (tv * tv / tt).max(ttv * ttv / tttt);
        let room = tt * tttt - ttt * ttt;
        let (a, c) = ((tv * tttt - ttv * ttt) / room, (ttv * tt - tv * ttt) / room);
        if a * c > 0.0 { a * tv + c * ttv } else { one }
    };
    let last = speed.len().checked_sub(CURVE)? as f64;
    let step = FINEST.max(last / MOST);
    let best = (0..=(last / step) as usize).map(|k| step * k as f64).fold((0.0, 0.0), |best, moment| {
        let of = explained(moment);
        if of > best.1 { (moment, of) } else { best }
    });
    (best.0 > 0.0 && best.0 + step <= last).then(|| best.0.round() as usize)
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    use signals::choose_cutoff;

    #[test]
    fn a_held_body_got_going_when_noise_of_the_encoder_last_changed_sign() {
        // to and fro, each way 50 mm/s after 50 ms, held for 60 ms between
        const DT: f64 = 1e-3;
        let speed = |t: f64| {
            let (way, since) = ((t / 0.31).floor(), t % 0.31);
            let up = ((since - 0.06) / 0.05).clamp(0.0, 1.0);
            let down = ((0.31 - since) / 0.05).clamp(0.0, 1.0);
            0.05 * up.min(down) * if way % 2.0 == 0.0 { 1.0 } else { -1.0 }
        };
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut noise = |std: f64| -> f64 {
            std * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut random)
        };
        let (mut position, mut force, mut x) = (Vec::new(), Vec::new(), 0.0);
        for i in 0..6_200_u32 {
            let t = f64::from(i) * DT;
            position.push(((x + noise(1e-6)) / 2.5e-6).round() * 2.5e-6);
            x += DT * speed(t + 0.5 * DT);
            let (v, a) = (speed(t), (speed(t + 0.5 * DT) - speed(t - 0.5 * DT)) / DT);
            force.push(0.4 * a + v.signum() + noise(0.05));
        }
        let channels = Channels { dt: DT, position, force, ..Channels::default() };
        let cutoff = choose_cutoff(std::slice::from_ref(&channels));
        let track = Track::new(channels, cutoff, Reversals::default());
        let found: Vec<f64> =
            (1..track.len()).filter(|&i| track.sign[i] != track.sign[i - 1]).map(|i| i as f64 * DT).collect();
        assert_eq!(found.len(), 19);
        let late: Vec<f64> =
            (1..20).zip(&found).map(|(way, at)| 1e3 * (at - 0.31 * f64::from(way) - 0.06)).collect();
        let rms = (late.iter().map(|d| d * d).sum::<f64>() / late.len() as f64).sqrt();
        println!("cut-off {cutoff:.0} Hz; late by {late:.1?} ms, rms {rms:.2} ms");
        assert!(rms < 2.0);
    }

    #[test]
    fn an_acceleration_near_the_cut_off_was_a_tenth_too_small() {
        const DT: f64 = 1e-3;
        let w = std::f64::consts::TAU * 80.0;
        let position: Vec<f64> = (0..2000).map(|i| 1e-4 * (w * DT * f64::from(i)).sin()).collect();
        let channels = Channels { dt: DT, force: vec![0.0; position.len()], position, ..Channels::default() };
        let track = Track::new(channels, 125.0, Reversals::default());
        let peak = track.a[500..1500].iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        let share = peak / (1e-4 * w * w);
        println!("{share:.4} of the acceleration");
        assert!((share - 1.0).abs() < 0.02);
    }
}
