//! The one zero-phase filter of a diagnosis, and what a channel's own noise does behind it.

use std::f64::consts::PI;

/// A fourth-order Butterworth low-pass run forward and backward: no phase, half power twice at the cut-off.
///
/// The same filter is applied to the force and to every regressor, so that a model linear in its gains stays
/// exactly linear behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    /// Cut-off, Hz.
    pub cutoff: f64,
    sections: [[f64; 5]; 2],
    /// Samples after which the response to an edge has died out.
    settle: usize,
}

impl LowPass {
    /// A low-pass at `cutoff` Hz for samples `dt` seconds apart; the cut-off is held below 0.45 of the rate.
    pub fn new(cutoff: f64, dt: f64) -> Self {
        let cutoff = cutoff.clamp(1e-9 / dt, 0.45 / dt);
        let k = (PI * cutoff * dt).tan();
        let section = |q: f64| {
            let norm = 1.0 / (1.0 + k / q + k * k);
            [
                k * k * norm,
                2.0 * k * k * norm,
                k * k * norm,
                2.0 * (k * k - 1.0) * norm,
                (1.0 - k / q + k * k) * norm,
            ]
        };
        let settle = (1.5 / (cutoff * dt)).ceil().min(1e9) as usize;
        Self { cutoff, sections: [section(0.541_196_100_146_197), section(1.306_562_964_876_377)], settle }
    }

    /// Samples to trim at either end.
    pub fn settle(&self) -> usize {
        self.settle
    }

    /// Filters forward and backward; the ends are continued by odd reflection.
    pub fn apply(&self, series: &[f64]) -> Vec<f64> {
        self.apply_lanes(series.as_chunks::<1>().0).into_iter().map(|[x]| x).collect()
    }

    /// The same for several series at once, which costs hardly more than one.
    pub fn apply_lanes<const L: usize>(&self, series: &[[f64; L]]) -> Vec<[f64; L]> {
        let n = series.len();
        if n < 4 {
            return series.to_vec();
        }
        let pad = self.settle.min(n - 1);
        let (first, last) = (series[0], series[n - 1]);
        let beyond = |end: &[f64; L], x: &[f64; L]| std::array::from_fn(|l| 2.0 * end[l] - x[l]);
        let mut padded = Vec::with_capacity(n + 2 * pad);
        padded.extend((1..=pad).rev().map(|i| beyond(&first, &series[i])));
        padded.extend_from_slice(series);
        padded.extend((1..=pad).map(|i| beyond(&last, &series[n - 1 - i])));
        self.run(padded.iter_mut());
        self.run(padded.iter_mut().rev());
        padded.truncate(pad + n);
        padded.drain(..pad);
        padded
    }

    /// Both biquads in transposed direct form II, started in the steady state of the first sample.
    fn run<'a, const L: usize>(&self, series: impl Iterator<Item = &'a mut [f64; L]>) {
        let mut series = series.peekable();
        let Some(start) = series.peek().map(|x| **x) else { return };
        // Unit gain at zero frequency: the output of a constant is the constant, in both sections.
        let mut state = self.sections.map(|[_, b1, b2, a1, a2]| {
            let z2 = start.map(|x| (b2 - a2) * x);
            let z1: [f64; L] = std::array::from_fn(|l| (b1 - a1) * start[l] + z2[l]);
            [z1, z2]
        });
        for x in series {
            for ([b0, b1, b2, a1, a2], [z1, z2]) in self.sections.iter().zip(&mut state) {
                for l in 0..L {
                    let y = b0 * x[l] + z1[l];
                    z1[l] = b1 * x[l] - a1 * y + z2[l];
                    z2[l] = b2 * x[l] - a2 * y;
                    x[l] = y;
                }
            }
        }
    }

    /// Standard deviation, behind the filter and an average of `stride` samples, of white noise of unit
    /// standard deviation in front of it.
    pub fn white_gain(&self, stride: usize) -> f64 {
        let n = 8 * self.settle + 4 * stride + 16;
        let mut impulse = vec![0.0; n];
        impulse[n / 2] = 1.0;
        let response = self.apply(&impulse);
        let stride = stride.max(1);
        response
            .windows(stride)
            .map(|w| {
                let mean = w.iter().sum::<f64>() / stride as f64;
                mean * mean
            })
            .sum::<f64>()
            .sqrt()
    }
}

/// Central differences; one-sided at the ends.
pub fn derivative(series: &[f64], dt: f64) -> Vec<f64> {
    let n = series.len();
    if n < 2 {
        return vec![0.0; n];
    }
    (0..n)
        .map(|i| {
            let (low, high) = (i.saturating_sub(1), (i + 1).min(n - 1));
            (series[high] - series[low]) / ((high - low) as f64 * dt)
        })
        .collect()
}

/// Standard deviation of a channel's white noise from its third differences.
///
/// The largest fifth of the differences is set aside, so that edges of the signal do not count as noise; a
/// quantised channel never has less than its quantum over √12.
pub fn local_noise(series: &[f64]) -> f64 {
    if series.len() < 16 {
        return 0.0;
    }
    let mut third: Vec<f64> =
        series.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs()).collect();
    let count = (third.len() * 4 / 5).max(1);
    third.select_nth_unstable_by(count - 1, f64::total_cmp);
    let kept = &third[..count];
    let mean_square = kept.iter().map(|d| d * d).sum::<f64>() / kept.len() as f64;
    // Var Δ³ = 20 σ²; a normal variable cut at its 80 % quantile keeps 0.4377 of its variance.
    let spread = (mean_square / (20.0 * 0.4377)).sqrt();
    spread.max(quantum(series) / 12f64.sqrt())
}

/// The smallest step between two different neighbouring samples that recurs, 0 for a continuous channel.
pub fn quantum(series: &[f64]) -> f64 {
    let mut steps: Vec<f64> = series.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 0.0).collect();
    let equal = series.len().saturating_sub(1) - steps.len();
    if steps.is_empty() {
        return 0.0;
    }
    let rank = steps.len() / 50;
    let smallest = *steps.select_nth_unstable_by(rank, f64::total_cmp).1;
    // A continuous channel hardly ever repeats a value exactly, and its steps are not multiples of one.
    let multiples = steps.iter().filter(|s| ((*s / smallest) - (*s / smallest).round()).abs() < 0.01).count();
    if equal * 20 > series.len() || multiples * 10 > steps.len() * 9 { smallest } else { 0.0 }
}

/// Root mean square.
pub fn rms(series: &[f64]) -> f64 {
    if series.is_empty() {
        return 0.0;
    }
    (series.iter().map(|x| x * x).sum::<f64>() / series.len() as f64).sqrt()
}

/// The value below which the share `p` of the finite samples lies.
pub fn quantile(series: &[f64], p: f64) -> f64 {
    let mut finite: Vec<f64> = series.iter().copied().filter(|x| x.is_finite()).collect();
    if finite.is_empty() {
        return 0.0;
    }
    let at = (p.clamp(0.0, 1.0) * (finite.len() - 1) as f64).round() as usize;
    *finite.select_nth_unstable_by(at, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_slow_stops_fast_and_has_no_phase() {
        let dt = 1e-3;
        let filter = LowPass::new(20.0, dt);
        for (hz, low, high) in [(2.0, 0.995, 1.005), (20.0, 0.45, 0.55), (100.0, 0.0, 1e-4)] {
            let wave: Vec<f64> = (0..4000).map(|i| (2.0 * PI * hz * i as f64 * dt).sin()).collect();
            let out = filter.apply(&wave);
            let (mut same, mut quarter, mut power) = (0.0, 0.0, 0.0);
            for (i, x) in out.iter().enumerate().take(3000).skip(1000) {
                let phase = 2.0 * PI * hz * i as f64 * dt;
                same += x * phase.sin();
                quarter += x * phase.cos();
                power += phase.sin().powi(2);
            }
            let (gain, lag) = (same / power, quarter / power);
            println!("{hz} Hz: gain {gain:.5}, quadrature {lag:.1e}");
            assert!(gain >= low && gain <= high && lag.abs() < 1e-4);
        }
    }

    #[test]
    fn white_gain_is_what_white_noise_shows() {
        use rand::SeedableRng;
        use rand_distr::{Distribution, StandardNormal};
        let filter = LowPass::new(30.0, 1e-3);
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let noise: Vec<f64> = (0..60_000).map(|_| StandardNormal.sample(&mut random)).collect();
        let (noise_level, out) = (local_noise(&noise), filter.apply(&noise));
        let rows: Vec<f64> = out.chunks_exact(10).map(|c| c.iter().sum::<f64>() / 10.0).collect();
        println!("local {noise_level:.4}, rows {:.4}, predicted {:.4}", rms(&rows), filter.white_gain(10));
        assert!((noise_level - 1.0).abs() < 0.02);
        assert!((rms(&rows) / filter.white_gain(10) - 1.0).abs() < 0.05);
    }
}
