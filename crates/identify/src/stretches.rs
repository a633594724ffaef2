//! Gap-free stretches of a recording, on an even grid.

use crate::Recording;
use crate::noise::noise_variance;
use std::f64::consts::TAU;
use std::ops::Range;

/// Fewest samples a stretch is worth keeping for.
pub(crate) const SHORTEST: usize = 64;

/// Samples without a gap, a step backward in time or a value that is not a number.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stretch {
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

    /// The column over this stretch, interpolated to the even grid.
    pub fn grid(&self, column: &[f64]) -> Vec<f64> {
        let part = column.get(self.range.clone()).unwrap_or(&[]);
        let Some(places) = self.places.as_ref().filter(|p| p.len() == part.len()) else {
            return part.to_vec();
        };
        let mut low = 0;
        (0..part.len())
            .map(|i| {
                while low + 2 < places.len() && places[low + 1] < i as f64 {
                    low += 1;
                }
                let share = (i as f64 - places[low]) / (places[low + 1] - places[low]);
                part[low] + share.clamp(0.0, 1.0) * (part[low + 1] - part[low])
            })
            .collect()
    }

    /// From the even grid back to the times of the samples.
    pub fn back(&self, grid: Vec<f64>) -> Vec<f64> {
        let Some(places) = self.places.as_ref().filter(|p| p.len() == grid.len()) else { return grid };
        let last = grid.len() - 2;
        places
            .iter()
            .map(|p| {
                let low = (p.max(0.0) as usize).min(last);
                grid[low] + (p - low as f64).clamp(0.0, 1.0) * (grid[low + 1] - grid[low])
            })
            .collect()
    }
}

/// Cuts at gaps and at values that are not numbers in any of `columns`; `dt` is the period of the clock.
pub(crate) fn cut(time: &[f64], columns: &[&[f64]], dt: f64) -> Vec<Stretch> {
    let good =
        |i: usize| time[i].is_finite() && columns.iter().all(|c| c.get(i).is_some_and(|x| x.is_finite()));
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
            if !(step > 0.05 * dt && step < 1.6 * dt) {
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

/// The columns of a recording that a fit needs, with holes closed by straight lines so that no value is NaN. None
/// where a column has no number at all.
pub(crate) fn closed(column: &[f64]) -> Option<Vec<f64>> {
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
pub(crate) fn rms_frequency(series: &[f64], dt: f64) -> f64 {
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
pub(crate) fn used(recording: &Recording) -> Vec<&[f64]> {
    let optional = [&recording.velocity, &recording.acceleration, &recording.normal_force];
    let mut out: Vec<&[f64]> = vec![&recording.position, &recording.force];
    out.extend(optional.into_iter().filter_map(|c| c.as_deref()));
    out
}
