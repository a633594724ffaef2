//! From channels to a regression: columns of the baseline and of effects, rows in blocks, and one more draw of the
//! sensors' noise.

use crate::library::applied_force::AppliedForce;
use crate::library::baseline::{BACKWARD, BASELINE, FORWARD, Physics};
use crate::library::kept::{Column, Kept};
use crate::library::quick::Quick;
use crate::library::series;
use crate::library::term::{Term, TermKind};
use crate::preparation::track::{Reversals, Track};
use crate::regression::linear::{Blocks, fit};
use friction::Motion;
use friction::effects::{EffectKind, MAX_GAINS, MAX_MEMORY, MAX_SHAPE, SeriesKind};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use signals::{Basis, Channels, dot, noise_std};
use std::sync::Arc;

/// Series that go through the filter together.
const LANES: usize = 8;

/// Number of shapes of an effect that share one pass over the motion.
pub fn shapes_together(kind: TermKind) -> usize {
    match kind {
        TermKind::Force(kind) => LANES / kind.gains().len().max(1),
        TermKind::Series(_) => 1,
    }
}

/// Sums of the columns that share a gain.
pub fn gather(all: &[&[f64]], groups: &[&[usize]]) -> Vec<Vec<f64>> {
    groups
        .iter()
        .map(|members| {
            let mut sum = vec![0.0; all.first().map_or(0, |c| c.len())];
            for column in members.iter().filter_map(|m| all.get(*m)) {
                for (s, x) in sum.iter_mut().zip(*column) {
                    *s += x;
                }
            }
            sum
        })
        .collect()
}

/// Everything the regressors are made from, and how rows become blocks.
#[derive(Debug, Clone)]
pub struct DesignMatrix {
    /// Gap-free stretches, in order of time within a recording.
    pub tracks: Vec<Track>,
    /// Share of each row's samples that are used.
    pub share: Vec<f64>,
    /// Blocks of rows.
    pub blocks: Blocks,
    /// Filtered, masked force.
    pub y: Vec<f64>,
    /// The same for the baseline's columns.
    pub baseline: Vec<Vec<f64>>,
    /// Which of [`BASELINE`] are the first columns of `baseline`: those of a direction in which the body does not move
    /// are not there.
    pub present: Vec<usize>,
    /// The delay of the force is the column of the baseline behind them.
    pub delay: bool,
    /// Direction of the mass's column outside the rest of the baseline, times the root of the share of its square there that is noise.
    mass_noise: Vec<f64>,
    /// Columns computed lately.
    kept: Kept,
}

impl DesignMatrix {
    /// The body moves in one direction only.
    pub fn is_one_way(&self) -> bool {
        self.present.len() < BASELINE.len()
    }

    /// Baseline of a fit. A direction that was not seen is given what the other has.
    pub fn physics(&self, coefficients: &[f64]) -> Physics {
        let of = |wanted: usize| Some(coefficients[self.present.iter().position(|p| *p == wanted)?]);
        let other = [0, 2, 1, 4, 3];
        std::array::from_fn(|i| of(i).or_else(|| of(other[i])).unwrap_or(0.0))
    }

    /// Rows of a series per track that is already filtered.
    pub fn rows(&self, of: impl Fn(&Track) -> Vec<f64>) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.share.len());
        for track in &self.tracks {
            track.rows(&of(track), &mut out);
        }
        out
    }

    /// Number of rows of which most samples are used.
    pub fn used_rows(&self) -> usize {
        self.share.iter().filter(|s| **s > 0.5).count()
    }

    /// Share of the samples that are used.
    pub fn judged_share(&self) -> f64 {
        let judged: f64 = self.tracks.iter().flat_map(|t| &t.mask).sum();
        judged / self.tracks.iter().map(Track::len).sum::<usize>().max(1) as f64
    }

    /// Effective number of rows in each block.
    pub fn block_weight(&self) -> Vec<f64> {
        (0..self.blocks.len()).map(|k| self.blocks.rows(k).map(|r| self.share[r]).sum()).collect()
    }

    /// Effective number of rows.
    pub fn effective_rows(&self) -> f64 {
        self.block_weight().iter().sum()
    }

    /// Root mean square of a row, from the squares of all.
    pub fn rms(&self, squared: f64) -> f64 {
        (squared / self.effective_rows().max(1e-300)).sqrt()
    }

    /// Columns of a term, one per free gain.
    pub fn columns(&self, term: &Term) -> Vec<Vec<f64>> {
        let all = self.all_columns(term.kind, &term.shape);
        gather(&all.iter().map(Vec::as_slice).collect::<Vec<_>>(), term.free_gains())
    }

    /// The same, of those that were computed lately as they are known.
    pub fn kept_columns(&self, term: &Term) -> Arc<[Column]> {
        self.kept.get(term, || self.columns(term))
    }

    /// Columns of an effect, one per gain.
    pub fn all_columns(&self, kind: TermKind, shape: &[f64; MAX_SHAPE]) -> Vec<Vec<f64>> {
        self.columns_at(kind, std::slice::from_ref(shape)).pop().unwrap_or_default()
    }

    /// The same at as many shapes as [`shapes_together`] says, in one pass over the motion.
    pub fn columns_at(&self, kind: TermKind, shapes: &[[f64; MAX_SHAPE]]) -> Vec<Vec<Vec<f64>>> {
        match kind {
            TermKind::Series(kind) => shapes.iter().map(|shape| self.series_columns(kind, shape)).collect(),
            TermKind::Force(kind) => match kind.gains().len() * shapes.len() {
                0 | 1 => self.force_columns::<1>(kind, shapes),
                2 => self.force_columns::<2>(kind, shapes),
                3 | 4 => self.force_columns::<4>(kind, shapes),
                _ => self.force_columns::<LANES>(kind, shapes),
            },
        }
    }

    fn series_columns(&self, kind: SeriesKind, shape: &[f64; MAX_SHAPE]) -> Vec<Vec<f64>> {
        let column = |gain: usize| {
            let mut out = Vec::with_capacity(self.share.len());
            for track in &self.tracks {
                track.rows(&track.pass(&series::column(track, kind, gain, shape)), &mut out);
            }
            out
        };
        (0..kind.about().gains.len()).map(column).collect()
    }

    /// Rows of the force per unit of each gain at each shape, in `L` lanes: the gains of the first shape, of the next, ….
    fn force_columns<const L: usize>(
        &self,
        kind: EffectKind,
        shapes: &[[f64; MAX_SHAPE]],
    ) -> Vec<Vec<Vec<f64>>> {
        let mut out = vec![Vec::with_capacity(self.share.len()); L];
        for (track, series) in self.tracks.iter().zip(self.units::<L>(kind, shapes)) {
            track.passed_rows(series, &mut out);
        }
        let mut columns = out.into_iter();
        let gains = kind.gains().len();
        shapes.iter().map(|_| columns.by_ref().take(gains).collect()).collect()
    }

    /// Force per unit of each gain at each shape, at every sample of every track.
    fn units<const L: usize>(&self, kind: EffectKind, shapes: &[[f64; MAX_SHAPE]]) -> Vec<Vec<[f64; L]>> {
        let gains = kind.gains().len();
        let shapes: Vec<[Quick; MAX_SHAPE]> = shapes.iter().map(|shape| shape.map(Quick)).collect();
        self.walk(
            || [[Quick(0.0); MAX_MEMORY]; L],
            |memories, motion| {
                let motion = Motion {
                    dt: Quick(motion.dt),
                    position: Quick(motion.position),
                    displacement: Quick(motion.displacement),
                    velocity: Quick(motion.velocity),
                    applied: Quick(motion.applied),
                    mass: Quick(motion.mass),
                    normal: motion.normal.map(Quick),
                };
                let mut lanes = [0.0; L];
                for ((shape, memory), lanes) in shapes.iter().zip(memories).zip(lanes.chunks_mut(gains)) {
                    for (lane, Quick(unit)) in lanes.iter_mut().zip(kind.unit(shape, memory, &motion)) {
                        *lane = if unit.is_finite() { unit } else { 0.0 };
                    }
                }
                lanes
            },
        )
    }

    /// What `step` makes of the motion at every sample of every track. The memory, `fresh` for each recording, runs through
    /// the gaps of a recording.
    pub(crate) fn walk<M, T>(
        &self,
        fresh: impl Fn() -> M,
        mut step: impl FnMut(&mut M, &Motion<f64>) -> T,
    ) -> Vec<Vec<T>> {
        let mut memory = fresh();
        let mut previous: Option<&Track> = None;
        let mut out = Vec::with_capacity(self.tracks.len());
        for track in &self.tracks {
            match previous {
                Some(last) if last.raw.recording == track.raw.recording => {
                    let gap = track.raw.start - last.time(last.len());
                    let jump = track.x[0] - last.x[last.len() - 1];
                    if gap > 0.0 {
                        let motion =
                            Motion { dt: gap, displacement: jump, velocity: jump / gap, ..motion(track, 0) };
                        step(&mut memory, &motion);
                    }
                }
                _ => memory = fresh(),
            }
            out.push((0..track.len()).map(|i| step(&mut memory, &motion(track, i))).collect());
            previous = Some(track);
        }
        out
    }
}

/// The motion of sample `i` as a law sees it; the direction is the track's, which does not flicker in noise.
fn motion(track: &Track, i: usize) -> Motion<f64> {
    let displacement = if i > 0 { track.x[i] - track.x[i - 1] } else { 0.0 };
    let speed = track.v[i] * track.sign[i];
    Motion {
        dt: track.raw.dt,
        position: track.x[i],
        displacement,
        velocity: track.sign[i] * speed.max(1e-12),
        applied: track.force_model[i],
        mass: 0.0,
        normal: track.normal.as_ref().map(|n| n[i]),
    }
}

/// Share of the samples in use below which those that go the other way are strays, a few where the body gets going or
/// comes to rest.
const STRAYS: f64 = 0.01;

/// Which of [`BASELINE`] the motion has something to say about. Strays of the other direction are set aside.
fn directions(tracks: &mut [Track]) -> Vec<usize> {
    let used = |forward: bool| -> f64 {
        let of = |t: &Track| {
            t.sign.iter().zip(&t.mask).filter(|(s, _)| (**s > 0.0) == forward).map(|(_, m)| m).sum::<f64>()
        };
        tracks.iter().map(of).sum()
    };
    let (forward, backward) = (used(true), used(false));
    let stray = |few: f64| few < STRAYS * (forward + backward);
    let (present, wanted) = match (stray(backward), stray(forward)) {
        (true, _) => (FORWARD.to_vec(), 1.0),
        (_, true) => (BACKWARD.to_vec(), -1.0),
        _ => return (0..BASELINE.len()).collect(),
    };
    for t in tracks {
        for (mask, sign) in t.mask.iter_mut().zip(&t.sign) {
            if *sign != wanted {
                *mask = 0.0;
            }
        }
    }
    present
}

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

impl DesignMatrix {
    /// Filters `stretches` at `cutoff` Hz and fits the baseline once. None when too few rows are left.
    ///
    /// With `delay` the time between force and position is fitted jointly with everything else: a sixth column of
    /// the baseline.
    pub fn new(stretches: &[Channels], cutoff: f64, reversals: Reversals, delay: bool) -> Option<Self> {
        let mut tracks: Vec<Track> = stretches
            .iter()
            .filter(|c| c.position.len() >= 16)
            .map(|c| Track::new(c.clone(), cutoff, reversals))
            .filter(|t| t.row_count() >= 24)
            .collect();
        let present = directions(&mut tracks);
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
        let (y, baseline, mass_noise, kept) = (Vec::new(), Vec::new(), Vec::new(), Kept::default());
        let mut design = Self { tracks, share, blocks, y, baseline, present, delay, mass_noise, kept };
        design.fill();
        let first = fit(&design.baseline, &design.y, &design.blocks, 4);
        if let Some(first) = &first {
            design.measure_noise(cutoff, &first.coefficients);
            design.measure_mass_noise();
            let second = fit(&design.baseline, &design.y, &design.blocks, 4);
            let coefficients = &second.as_ref().unwrap_or(first).coefficients;
            design.blocks.mass = coefficients[0];
            let acting = AppliedForce::baseline(design.physics(coefficients));
            design.model_force(&acting);
        }
        Some(design)
    }

    /// Measures the acceleration's noise in every block by drawing it once more.
    fn measure_noise(&mut self, cutoff: f64, coefficients: &[f64]) {
        let clean = self.rows(|t| t.pass(&t.a));
        let other = self
            .perturbed(cutoff, &AppliedForce::baseline(self.physics(coefficients)), 0xacce)
            .rows(|t| t.pass(&t.a));
        let noise = |k: usize| self.blocks.rows(k).map(|r| (other[r] - clean[r]).powi(2)).sum();
        self.blocks.noise = (0..self.blocks.len()).map(noise).collect();
    }

    fn measure_mass_noise(&mut self) {
        let Some((mass, others)) = self.baseline.split_first() else { return };
        let outside = Basis::of(others).project_out(mass);
        let power = dot(&outside, &outside);
        if power > 0.0 {
            let share = (self.blocks.noise.iter().sum::<f64>() / power).min(1.0);
            self.mass_noise = outside.iter().map(|x| x * (share / power).sqrt()).collect();
        }
    }

    /// Squared length that a column keeps outside the baseline only because the acceleration is noisy. On a single sine a spring is
    /// collinear with the mass, and all that is left of it is this.
    pub fn noise_beside(&self, column: &[f64]) -> f64 {
        dot(&self.mass_noise, column).powi(2)
    }

    fn fill(&mut self) {
        self.y = self.rows(|t| t.pass(&t.f));
        let per_track: Vec<[Vec<f64>; 5]> = self.tracks.iter().map(Track::baseline).collect();
        self.baseline = self
            .present
            .iter()
            .map(|&c| {
                let mut column = Vec::with_capacity(self.share.len());
                for (track, series) in self.tracks.iter().zip(&per_track) {
                    track.rows(&track.pass(&series[c]), &mut column);
                }
                column
            })
            .collect();
        if self.delay {
            self.baseline.push(self.rows(|t| t.pass(&t.late())));
        }
    }

    /// The same design matrix with one more draw of every sensor's noise, rows unchanged.
    pub fn perturbed(&self, cutoff: f64, acting: &AppliedForce, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut noisy = |series: &[f64]| -> Vec<f64> {
            let level = noise_std(series);
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
                let mut track = Track::new(raw, cutoff, t.reversals);
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
        let mut out = Self { y: Vec::new(), baseline: Vec::new(), mass_noise: Vec::new(), ..self.clone() };
        out.tracks.iter_mut().for_each(|t| t.mask.fill(1.0));
        out
    }

    /// Residual at every sample of every track, behind the filter.
    pub fn sample_residual(&self, baseline: &Physics) -> Vec<Vec<f64>> {
        self.tracks
            .iter()
            .map(|t| {
                let mut left = t.f.clone();
                for (series, c) in t.baseline().iter().zip(baseline) {
                    for (l, s) in left.iter_mut().zip(series) {
                        *l -= c * s;
                    }
                }
                t.pass(&left)
            })
            .collect()
    }
}

impl DesignMatrix {
    /// Sets the force that stands for the applied force inside regressors.
    pub fn model_force(&mut self, acting: &AppliedForce) {
        let mut forces: Vec<Vec<f64>> = self
            .tracks
            .iter()
            .map(|track| {
                let series = track.baseline();
                let at = |i: usize| series.iter().zip(&acting.baseline).map(|(s, c)| c * s[i]).sum();
                (0..track.len()).map(at).collect()
            })
            .collect();
        for (kind, gains, shape) in &acting.effects {
            for (force, units) in forces.iter_mut().zip(self.units::<MAX_GAINS>(*kind, &[*shape])) {
                for (f, unit) in force.iter_mut().zip(units) {
                    *f += unit.iter().zip(gains).map(|(u, g)| u * g).sum::<f64>();
                }
            }
        }
        for (track, force) in self.tracks.iter_mut().zip(forces) {
            track.force_model = force;
        }
        self.kept = Kept::default();
    }
}
