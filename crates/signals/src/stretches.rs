//! Gap-free stretches of a recording, on an even grid.

use crate::Recording;
use crate::noise::noise_variance;
use std::f64::consts::TAU;
use std::ops::Range;

/// Fewest samples a stretch is worth keeping for.
pub const SHORTEST: usize = 64;

/// Samples without a gap, a step backward in time or a value that is not a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Samples of the recording.
    pub range: Range<usize>,
    /// Mean time between samples, s.
    pub dt: f64,
    /// Where each sample is on the even grid, in samples from the first; None if the clock is even.
    places: Option<Vec<f64>>,
}

impl Stretch {
    fn new(time: &[f64], range: Range<usize>) -> Self {
        let t = &time[range.clone()];
        let n = t.len();
        let dt = (t[n - 1] - t[0]) / (n - 1) as f64;
        let place = |i: usize| (t[i] - t[0]) / dt;
        let even = (0..n).all(|i| (place(i) - i as f64).abs() < 0.02);
        Self { range, dt, places: (!even).then(|| (0..n).map(place).collect()) }
    }

    /// The column over this stretch on the even grid.
    ///
    /// A value of the grid is the sample nearest to it, moved there along a parabola through the five around that sample. So
    /// white noise stays white and as large as it was: between two samples a straight line has less of it, and a lower
    /// derivative, and the noise that a fit corrects for would be underestimated.
    pub fn grid(&self, column: &[f64]) -> Vec<f64> {
        let part = column.get(self.range.clone()).unwrap_or(&[]);
        let Some(places) = self.places.as_ref().filter(|p| p.len() == part.len()) else {
            return part.to_vec();
        };
        let mut nearest = 0;
        (0..part.len())
            .map(|i| {
                let off = |k: usize| (places[k] - i as f64).abs();
                while nearest + 1 < places.len() && off(nearest + 1) <= off(nearest) {
                    nearest += 1;
                }
                moved(places, part, nearest, i as f64)
            })
            .collect()
    }

    /// From the even grid back to the times of the samples, by cubics.
    pub fn back(&self, grid: Vec<f64>) -> Vec<f64> {
        let Some(places) = self.places.as_ref().filter(|p| p.len() == grid.len()) else { return grid };
        places.iter().map(|place| cubic(&grid, *place)).collect()
    }
}

/// The value of sample `k` moved to another place, along the parabola of least squares through the five samples around it.
fn moved(places: &[f64], values: &[f64], k: usize, to: f64) -> f64 {
    let first = k.saturating_sub(2).min(values.len() - 5);
    let [mut s1, mut s2, mut s3, mut s4, mut y0, mut y1, mut y2] = [0.0; 7];
    for j in first..first + 5 {
        let (u, y) = (places[j] - places[k], values[j] - values[k]);
        (s1, s2, s3, s4) = (s1 + u, s2 + u * u, s3 + u * u * u, s4 + u * u * u * u);
        (y0, y1, y2) = (y0 + y, y1 + u * y, y2 + u * u * y);
    }
    // normal equations of a + b u + c u², with a eliminated
    let (s11, s12, s22) = (s2 - s1 * s1 / 5.0, s3 - s1 * s2 / 5.0, s4 - s2 * s2 / 5.0);
    let (r1, r2) = (y1 - s1 * y0 / 5.0, y2 - s2 * y0 / 5.0);
    let determinant = s11 * s22 - s12 * s12;
    let (slope, bend) = ((r1 * s22 - r2 * s12) / determinant, (r2 * s11 - r1 * s12) / determinant);
    let u = to - places[k];
    values[k] + slope * u + bend * u * u
}

/// The value of an even series at a place between its samples, by the cubic through the four around it.
fn cubic(series: &[f64], place: f64) -> f64 {
    let first = (place.floor() as usize).saturating_sub(1).min(series.len() - 4);
    let u = place - first as f64;
    let nodes = [0.0, 1.0, 2.0, 3.0];
    let weight = |a: f64| -> f64 { nodes.iter().filter(|b| **b != a).map(|b| (u - b) / (a - b)).product() };
    nodes.iter().zip(&series[first..]).map(|(a, y)| weight(*a) * y).sum()
}

/// Steps of an even clock, and of one that is uneven by itself, from which on a sample is missing.
const GAP: f64 = 1.6;
const GAP_OF_UNEVEN: f64 = 3.0;
/// Root mean square deviation of the steps, as a share of the period, from which on a clock is uneven.
const UNEVEN: f64 = 0.05;

/// The longest step of the clock over which no sample is missing, s. Where a clock is uneven by itself, a sample that comes
/// late is not one that is missing.
fn longest_step(time: &[f64], dt: f64) -> f64 {
    let steps = time.windows(2).map(|w| (w[1] - w[0]) / dt).filter(|s| *s > 0.0 && *s < 1.5);
    let (squares, count) = steps.fold((0.0, 0.0), |(sum, n), s| (sum + (s - 1.0).powi(2), n + 1.0));
    if squares > UNEVEN * UNEVEN * count { GAP_OF_UNEVEN * dt } else { GAP * dt }
}

/// Cuts at gaps and at values that are not numbers in any of `columns`; `dt` is the period of the clock.
pub fn cut(time: &[f64], columns: &[&[f64]], dt: f64) -> Vec<Stretch> {
    let good =
        |i: usize| time[i].is_finite() && columns.iter().all(|c| c.get(i).is_some_and(|x| x.is_finite()));
    let longest = longest_step(time, dt);
    let mut out = Vec::new();
    let mut close = |range: Range<usize>| {
        if range.len() >= SHORTEST {
            out.push(Stretch::new(time, range));
        }
    };
    let mut start = 0;
    for i in 0..time.len() {
        if !good(i) {
            close(start..i);
            start = i + 1;
        } else if i > start {
            let step = time[i] - time[i - 1];
            if !(step > 0.05 * dt && step < longest) {
                close(start..i);
                start = i;
            }
        }
    }
    if start < time.len() {
        close(start..time.len());
    }
    out
}

/// Cuts stretches in front of the samples `at`, in ascending order.
pub fn split(time: &[f64], stretches: Vec<Stretch>, at: &[usize]) -> Vec<Stretch> {
    let parts = |s: Stretch| -> Vec<Stretch> {
        let inside: Vec<usize> =
            at.iter().copied().filter(|i| *i > s.range.start && *i < s.range.end).collect();
        if inside.is_empty() {
            return vec![s];
        }
        let starts = std::iter::once(s.range.start).chain(inside.iter().copied());
        let ends = inside.iter().copied().chain([s.range.end]);
        let long = starts.zip(ends).filter(|(from, to)| to - from >= SHORTEST);
        long.map(|(from, to)| Stretch::new(time, from..to)).collect()
    };
    stretches.into_iter().flat_map(parts).collect()
}

/// The columns of a recording that a fit needs, with holes closed by straight lines so that no value is NaN. None
/// where a column has no number at all.
pub fn closed(column: &[f64]) -> Option<Vec<f64>> {
    let mut out = column.to_vec();
    let mut known: Option<usize> = None;
    for i in 0..out.len() {
        if !out[i].is_finite() {
            continue;
        }
        let from = known.map_or(0, |k| k + 1);
        let here = out[i];
        for j in from..i {
            out[j] = match known {
                Some(k) => out[k] + (here - out[k]) * (j - k) as f64 / (i - k) as f64,
                None => here,
            };
        }
        known = Some(i);
    }
    let last = known?;
    let hold = out[last];
    out[last + 1..].fill(hold);
    Some(out)
}

/// Root mean square frequency of a channel, Hz: that of its derivative over its own, its white noise taken out.
pub fn rms_frequency(series: &[f64], dt: f64) -> f64 {
    let n = series.len();
    if n < 3 {
        return 0.0;
    }
    let mean = series.iter().sum::<f64>() / n as f64;
    let noise = noise_variance(series);
    let spread = series.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n as f64 - noise;
    let slope = series.windows(3).map(|w| (w[2] - w[0]).powi(2)).sum::<f64>() / (n - 2) as f64 - 2.0 * noise;
    let (spread, slope) = (spread.max(0.0), slope.max(0.0) / (4.0 * dt * dt));
    if spread > 0.0 { (slope / spread).sqrt() / TAU } else { 0.0 }
}

/// Every column a fit uses, in one list.
pub fn used(recording: &Recording) -> Vec<&[f64]> {
    let optional = [&recording.velocity, &recording.acceleration, &recording.normal_force];
    let mut out: Vec<&[f64]> = vec![&recording.position, &recording.force];
    out.extend(optional.into_iter().filter_map(|c| c.as_deref()));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_uneven_clock_made_noise_smaller_and_motion_slower() {
        // from 0.98 to 1.07 periods apart, as a loop without a timer has it
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / 2f64.powi(31)
        };
        let time: Vec<f64> = (0..4000)
            .scan(0.0, |t, _| Some(std::mem::replace(t, *t + 0.01 * (0.98 + 0.09 * random()))))
            .collect();
        let noise: Vec<f64> = time.iter().map(|_| (0..12).map(|_| random()).sum::<f64>() - 6.0).collect();
        let [stretch] = &cut(&time, &[&noise], 0.01)[..] else { panic!("one stretch") };
        let variance = noise_variance(&stretch.grid(&noise));
        println!("noise of variance {:.3} becomes {variance:.3}", noise_variance(&noise));
        assert!((variance / noise_variance(&noise) - 1.0).abs() < 0.05);
        let angle = |t: f64| TAU * 3.0 * t;
        let sine: Vec<f64> = time.iter().map(|t| angle(*t).sin()).collect();
        let worst = |found: &[f64], expected: &dyn Fn(usize) -> f64| {
            (5..found.len() - 5).map(|i| (found[i] - expected(i)).abs()).fold(0.0, f64::max)
        };
        let grid = stretch.grid(&sine);
        let there = worst(&grid, &|i| angle(i as f64 * stretch.dt).sin());
        let back = worst(&stretch.back(grid), &|i| sine[i]);
        println!("a sine of 30 samples is off by {there:.1e} on the grid and by {back:.1e} back from it");
        assert!(there < 3e-3 && back < 3e-3);
    }
}
