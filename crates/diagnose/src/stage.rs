//! From channels to a regression: stretches, weights, blocks, and one more draw of the sensors' noise.

use crate::linear::{Blocks, fit};
use crate::term::Stage;
use crate::track::{Channels, Track};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Fewest rows that can be split into blocks, fitted and held out.
pub const FEWEST_ROWS: usize = 120;

/// Cuts rows into blocks of about equal length that do not cross stretches.
fn cut(tracks: &[Track]) -> Blocks {
    let total: usize = tracks.iter().map(Track::row_count).sum();
    let wanted = (total / 20).clamp(8, 48);
    let mut edges = vec![0];
    let mut starts = Vec::new();
    let mut from = 0;
    for track in tracks {
        let rows = track.row_count();
        let count = ((rows * wanted + total / 2) / total.max(1)).max(1);
        for b in 0..count {
            edges.push(from + (b + 1) * rows / count);
            starts.push(b == 0);
        }
        from += rows;
    }
    Blocks { edges, starts }
}

impl Stage {
    /// Filters `stretches` at `cutoff` Hz, weighs rows by how well the sliding direction is known there and
    /// fits the baseline once. None when too few rows are left.
    pub fn new(stretches: &[Channels], cutoff: f64) -> Option<Self> {
        let tracks: Vec<Track> = stretches
            .iter()
            .filter(|c| c.position.len() >= 16)
            .map(|c| Track::new(c.clone(), cutoff))
            .filter(|t| t.row_count() >= 24)
            .collect();
        let blocks = cut(&tracks);
        let mut share = Vec::new();
        for track in &tracks {
            track.rows(&vec![1.0; track.len()], &mut share);
        }
        if share.iter().filter(|s| **s > 0.5).count() < FEWEST_ROWS {
            return None;
        }
        let weight = vec![1.0; share.len()];
        let mut stage = Self { tracks, weight, share, blocks, y: Vec::new(), baseline: Vec::new() };
        stage.fill();
        let first = fit(&stage.baseline, &stage.y, &stage.blocks, 4);
        if let Some(first) = &first {
            let coulomb = 0.5 * (first.coefficients[1].abs() + first.coefficients[2].abs());
            let mut sizes: Vec<f64> =
                first.residual.iter().zip(&stage.share).filter(|(_, s)| **s > 0.5).map(|(e, _)| e.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            let typical = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0) / 0.6745;
            let mut weights = Vec::with_capacity(stage.weight.len());
            for track in &stage.tracks {
                for r in 0..track.row_count() {
                    let rows = r * track.stride..(r + 1) * track.stride;
                    let error = track.reversal_error[rows].iter().sum::<f64>() / track.stride as f64 * coulomb;
                    let ratio = if typical > 0.0 { error / typical } else { 0.0 };
                    weights.push((1.0 + ratio * ratio).sqrt().recip());
                }
            }
            stage.weight = weights;
            stage.fill();
            let second = fit(&stage.baseline, &stage.y, &stage.blocks, 4);
            stage.model_force(&second.as_ref().unwrap_or(first).coefficients);
        }
        Some(stage)
    }

    fn fill(&mut self) {
        self.y = self.rows(|t| t.f.clone());
        let per_track: Vec<[Vec<f64>; 5]> = self.tracks.iter().map(Track::baseline).collect();
        self.baseline = (0..5)
            .map(|c| {
                let mut column = Vec::with_capacity(self.weight.len());
                for (track, series) in self.tracks.iter().zip(&per_track) {
                    track.rows(&series[c], &mut column);
                }
                column.iter().zip(&self.weight).map(|(x, w)| x * w).collect()
            })
            .collect();
        // A motion in one direction only has nothing to say about the other.
        self.baseline.retain(|c| c.iter().any(|x| *x != 0.0));
    }

    /// Sets the force that stands for the applied force inside regressors to what the baseline predicts.
    pub fn model_force(&mut self, coefficients: &[f64]) {
        if coefficients.len() != 5 {
            return;
        }
        for track in &mut self.tracks {
            let series = track.baseline();
            track.force_model = (0..track.len())
                .map(|i| series.iter().zip(coefficients).map(|(s, c)| c * s[i]).sum())
                .collect();
        }
    }

    /// The same stage with one more draw of every sensor's noise, rows and weights unchanged.
    pub fn perturbed(&self, cutoff: f64, coefficients: &[f64], seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut noisy = |series: &[f64]| -> Vec<f64> {
            let level = crate::signal::local_noise(series);
            series
                .iter()
                .map(|x| {
                    let draw: f64 = StandardNormal.sample(&mut random);
                    x + level * draw
                })
                .collect()
        };
        let mut out = self.clone();
        out.tracks = self
            .tracks
            .iter()
            .map(|t| {
                let raw = Channels {
                    position: noisy(&t.raw.position),
                    velocity: t.raw.velocity.as_deref().map(&mut noisy),
                    acceleration: t.raw.acceleration.as_deref().map(&mut noisy),
                    force: noisy(&t.raw.force),
                    normal: t.raw.normal.as_deref().map(&mut noisy),
                    ..t.raw.clone()
                };
                let mut track = Track::new(raw, cutoff);
                track.mask.clone_from(&t.mask);
                track.stride = t.stride;
                track
            })
            .collect();
        out.model_force(coefficients);
        out
    }

    /// Residual at every sample of every track, behind the filter, for given baseline coefficients.
    pub fn sample_residual(&self, coefficients: &[f64]) -> Vec<Vec<f64>> {
        self.tracks
            .iter()
            .map(|t| {
                let series = t.baseline();
                let used: Vec<&Vec<f64>> = series.iter().filter(|_| coefficients.len() == 5).collect();
                (0..t.len())
                    .map(|i| t.f[i] - used.iter().zip(coefficients).map(|(s, c)| c * s[i]).sum::<f64>())
                    .collect()
            })
            .collect()
    }
}
