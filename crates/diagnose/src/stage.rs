//! From channels to a regression: stretches, blocks, and one more draw of the sensors' noise.

use crate::acting::Acting;
use crate::linear::{Blocks, fit};
use crate::signal::derivative;
use crate::term::Stage;
use crate::track::{Channels, Track};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Fewest rows that can be split into blocks, fitted and held out.
pub const FEWEST_ROWS: usize = 60;

/// Cuts rows into blocks of about equal length that do not cross stretches.
fn cut(tracks: &[Track]) -> Blocks {
    let total: usize = tracks.iter().map(Track::row_count).sum();
    let wanted = (total / 20).clamp(8, 48);
    let mut edges = vec![0];
    let (mut starts, mut recordings) = (Vec::new(), Vec::new());
    let mut from = 0;
    for track in tracks {
        let rows = track.row_count();
        let count = ((rows * wanted + total / 2) / total.max(1)).max(1);
        for b in 0..count {
            edges.push(from + (b + 1) * rows / count);
            starts.push(b == 0);
            recordings.push(track.raw.recording);
        }
        from += rows;
    }
    Blocks { edges, starts, recordings, ..Blocks::default() }
}

impl Stage {
    /// Filters `stretches` at `cutoff` Hz and fits the baseline once. None when too few rows are left.
    ///
    /// With `delay` the time between force and position is fitted jointly with everything else: a sixth column of
    /// the baseline.
    pub fn new(stretches: &[Channels], cutoff: f64, delay: bool) -> Option<Self> {
        let tracks: Vec<Track> = stretches
            .iter()
            .filter(|c| c.position.len() >= 16)
            .map(|c| Track::new(c.clone(), cutoff))
            .filter(|t| t.row_count() >= 24)
            .collect();
        let blocks = cut(&tracks);
        let mut share = Vec::new();
        for track in &tracks {
            track.rows(&track.pass(&vec![1.0; track.len()]), &mut share);
        }
        // what a residual keeps of its square
        share.iter_mut().for_each(|s| *s *= *s);
        if share.iter().filter(|s| **s > 0.5).count() < FEWEST_ROWS {
            return None;
        }
        let mut stage = Self { tracks, share, blocks, y: Vec::new(), baseline: Vec::new(), delay };
        stage.fill();
        let first = fit(&stage.baseline, &stage.y, &stage.blocks, 4);
        if let Some(first) = &first {
            stage.measure_noise(cutoff, &first.coefficients);
            let second = fit(&stage.baseline, &stage.y, &stage.blocks, 4);
            let coefficients = &second.as_ref().unwrap_or(first).coefficients;
            stage.blocks.mass = coefficients[0];
            stage.model_force(&Acting::baseline(coefficients));
        }
        Some(stage)
    }

    /// Measures the acceleration's noise in every block by drawing it once more.
    fn measure_noise(&mut self, cutoff: f64, coefficients: &[f64]) {
        let clean = self.rows(|t| t.pass(&t.a));
        let other = self.perturbed(cutoff, &Acting::baseline(coefficients), 0xacce).rows(|t| t.pass(&t.a));
        let noise = |k: usize| self.blocks.rows(k).map(|r| (other[r] - clean[r]).powi(2)).sum();
        self.blocks.noise = (0..self.blocks.len()).map(noise).collect();
    }

    fn fill(&mut self) {
        self.y = self.rows(|t| t.pass(&t.raw.force));
        let per_track: Vec<[Vec<f64>; 5]> = self.tracks.iter().map(Track::baseline).collect();
        self.baseline = (0..5)
            .map(|c| {
                let mut column = Vec::with_capacity(self.share.len());
                for (track, series) in self.tracks.iter().zip(&per_track) {
                    track.rows(&track.pass(&series[c]), &mut column);
                }
                column
            })
            .collect();
        // A motion in one direction only has nothing to say about the other.
        self.baseline.retain(|c| c.iter().any(|x| *x != 0.0));
        if self.delay && self.baseline.len() == 5 {
            // below a sample the first term of the shift is all there is of it
            let late =
                self.rows(|t| t.pass(&derivative(&t.f, t.raw.dt).iter().map(|r| -r).collect::<Vec<_>>()));
            self.baseline.push(late);
        }
    }

    /// The same stage with one more draw of every sensor's noise, rows unchanged.
    pub fn perturbed(&self, cutoff: f64, acting: &Acting, seed: u64) -> Self {
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
        out.model_force(acting);
        out.fill();
        out
    }

    /// The same with nothing set aside, for columns of terms only.
    pub fn unmasked(&self) -> Self {
        let mut out = Self { y: Vec::new(), baseline: Vec::new(), ..self.clone() };
        out.tracks.iter_mut().for_each(|t| t.mask.fill(1.0));
        out
    }

    /// Residual at every sample of every track, behind the filter, for given baseline coefficients.
    pub fn sample_residual(&self, coefficients: &[f64]) -> Vec<Vec<f64>> {
        self.tracks
            .iter()
            .map(|t| {
                let mut left = t.raw.force.clone();
                if coefficients.len() >= 5 {
                    for (series, c) in t.baseline().iter().zip(coefficients) {
                        for (l, s) in left.iter_mut().zip(series) {
                            *l -= c * s;
                        }
                    }
                }
                t.pass(&left)
            })
            .collect()
    }
}
