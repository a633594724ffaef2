//! The zero-phase low-pass of the default preparation, and its gain for white noise.

use crate::filter::{Filter, Section, continued, run};
use pulp::Arch;

/// Order of one pass.
const ORDER: usize = 4;
/// Periods of the cut-off after which the response to an edge has died out, and by which a series is continued.
const SETTLE: f64 = 1.5;

/// A fourth-order Butterworth low-pass run forward and backward: no phase, a quarter of the power at the cut-off.
///
/// The same filter is applied to the force and to every regressor, so that a model linear in its gains stays
/// exactly linear behind it. A series is continued by odd reflection over 1.5 periods of the cut-off: over a fixed
/// number of samples a low cut-off would still swing at the first of them.
///
/// ```
/// let low_pass = signals::LowPass::new(20.0, 1e-3);
/// let line: Vec<f64> = (0..1000).map(|i| 2.0 * f64::from(i)).collect();
/// assert!((low_pass.apply(&line)[500] - line[500]).abs() < 1e-6);
/// // half of the amplitude is left at the cut-off: 20 Hz are 0.04 of half the sampling rate
/// assert!((low_pass.gain(0.04) - 0.5).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    cutoff: f64,
    sections: [Section; 2],
    settle: usize,
}

impl LowPass {
    /// A low-pass at `cutoff` Hz for samples `dt` seconds apart; the cut-off is held between 1e-6 and 0.45 of the rate.
    #[must_use]
    pub fn new(cutoff: f64, dt: f64) -> Self {
        let held = if cutoff > 0.0 { cutoff.min(0.45 / dt) } else { 0.0 }.max(1e-6 / dt);
        let identity = Section { b: [1.0, 0.0, 0.0], a: [0.0; 2] };
        let sections = Filter::butterworth(ORDER, held, dt).ok();
        let sections = sections.and_then(|f| f.sections().try_into().ok()).unwrap_or([identity; 2]);
        Self { cutoff: held, sections, settle: (SETTLE / (held * dt)).ceil().min(1e9) as usize }
    }

    /// The cut-off, Hz.
    #[must_use]
    pub fn cutoff(&self) -> f64 {
        self.cutoff
    }

    /// Samples to trim at either end: as far as an edge swings.
    #[must_use]
    pub fn settle(&self) -> usize {
        self.settle
    }

    /// Gain, forward and backward together, at a frequency given as a fraction of half the sampling rate.
    #[must_use]
    pub fn gain(&self, fraction: f64) -> f64 {
        self.sections.iter().map(|s| s.gain(fraction).powi(2)).product()
    }

    /// Filters forward and backward. A series of fewer than 4 samples comes back as it is.
    #[must_use]
    pub fn apply(&self, series: &[f64]) -> Vec<f64> {
        self.apply_lanes(series.as_chunks::<1>().0).into_iter().map(|[x]| x).collect()
    }

    /// The same for several series at once, which costs hardly more than one.
    #[must_use]
    pub fn apply_lanes<const L: usize>(&self, series: &[[f64; L]]) -> Vec<[f64; L]> {
        let n = series.len();
        if n < 4 {
            return series.to_vec();
        }
        let pad = self.settle.min(n - 1);
        let mut padded = continued(series, pad);
        // with the widest registers there are; nothing is fused, so the bits are the same. A closure that only borrows the
        // series would be called, not inlined, and use the narrowest.
        padded = Arch::new().dispatch(
            #[inline(always)]
            move || {
                run(self.sections, padded.iter_mut());
                run(self.sections, padded.iter_mut().rev());
                padded
            },
        );
        padded.truncate(pad + n);
        padded.drain(..pad);
        padded
    }

    /// Standard deviation, behind the filter and an average of `stride` samples, of white noise of unit
    /// standard deviation in front of it.
    #[must_use]
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::noise_variance;
    use crate::statistics::rms;
    use std::f64::consts::PI;

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
        let (noise_level, out) = (noise_variance(&noise).sqrt(), filter.apply(&noise));
        let rows: Vec<f64> = out.chunks_exact(10).map(|c| c.iter().sum::<f64>() / 10.0).collect();
        println!("local {noise_level:.4}, rows {:.4}, predicted {:.4}", rms(&rows), filter.white_gain(10));
        assert!((noise_level - 1.0).abs() < 0.02);
        assert!((rms(&rows) / filter.white_gain(10) - 1.0).abs() < 0.05);
    }
}
