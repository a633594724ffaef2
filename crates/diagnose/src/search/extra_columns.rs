//! Columns of the file that no effect reads: another joint's motion, a temperature, a supply. Where the error of the
//! baseline follows one of them, it is modelled by a free curve over that column before anything is named, so that no
//! effect of the catalogue stands in for what is known not to come from this body's own motion.

use crate::library::design_matrix::DesignMatrix;
use crate::preparation::track::Track;
use crate::regression::linear::{FOLDS, fit};
use crate::regression::sign_flips::gain_interval;
use signals::{Basis, Recording, dot, quantile};
use std::collections::BTreeMap;

/// Knots of a curve, at even quantiles.
const KNOTS: usize = 6;
/// Most columns that are followed.
const MOST: usize = 4;
/// Smallest share of the squared error that a curve takes away.
const MATERIAL: f64 = 0.05;
/// Share of a column that the force, the motion or the time explains from which on it is nothing of its own: a current is
/// the force once more, a set point the position.
const OWN: f64 = 0.9;

/// A further column of the recordings.
#[derive(Debug, Clone)]
pub struct ExtraColumn {
    /// As in the file.
    pub name: String,
    /// Times and values of each recording, those that are numbers.
    series: Vec<Vec<(f64, f64)>>,
}

/// A column that the error follows.
#[derive(Debug, Clone)]
pub struct Followed {
    /// Name of the column.
    pub name: String,
    /// Its curve multiplies the direction of motion: it is friction that follows.
    pub with_direction: bool,
    /// Places of the curve's knots.
    knots: Vec<f64>,
    /// Columns of the curve that the baseline does not contain already.
    kept: Vec<usize>,
    /// Root mean square error on blocks held out, without the curve and with it.
    pub rms: (f64, f64),
    /// 95 % interval of the gain.
    pub gain: [f64; 2],
}

/// The columns that every recording has.
pub fn of(recordings: &[Recording]) -> Vec<ExtraColumn> {
    let Some(first) = recordings.first() else { return Vec::new() };
    let named = |r: &Recording| {
        let mut all = r.extra.clone();
        all.extend(r.temperature.clone().map(|t| ("temperature_c".to_string(), t)));
        all
    };
    let all: Vec<_> = recordings.iter().map(named).collect();
    named(first)
        .into_keys()
        .filter(|name| all.iter().all(|r| r.contains_key(name)))
        .map(|name| {
            let of = |(r, columns): (&Recording, &BTreeMap<String, Vec<f64>>)| {
                let pairs = r.time.iter().zip(&columns[&name]).map(|(t, x)| (*t, *x));
                let mut pairs: Vec<(f64, f64)> =
                    pairs.filter(|(t, x)| t.is_finite() && x.is_finite()).collect();
                pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
                pairs
            };
            let series = recordings.iter().zip(&all).map(of).collect();
            ExtraColumn { name, series }
        })
        .collect()
}

impl ExtraColumn {
    /// Values at the samples of a track, linear between those there are.
    fn at(&self, track: &Track) -> Vec<f64> {
        let Some(series) = self.series.get(track.raw.recording).filter(|s| !s.is_empty()) else {
            return vec![0.0; track.len()];
        };
        let mut low = 0;
        (0..track.len())
            .map(|i| {
                let t = track.time(i);
                while low + 2 < series.len() && series[low + 1].0 < t {
                    low += 1;
                }
                let (a, b) = (series[low], series[(low + 1).min(series.len() - 1)]);
                let share = if b.0 > a.0 { ((t - a.0) / (b.0 - a.0)).clamp(0.0, 1.0) } else { 0.0 };
                a.1 + share * (b.1 - a.1)
            })
            .collect()
    }

    /// Whether the force, the motion and the time leave something of it.
    fn is_own(&self, design: &DesignMatrix) -> bool {
        let rows = |of: &dyn Fn(&Track) -> Vec<f64>| design.rows(|t| t.pass(&of(t)));
        let own = rows(&|t| self.at(t));
        let one = rows(&|t| vec![1.0; t.len()]);
        let varies = Basis::of(std::slice::from_ref(&one)).project_out(&own);
        let size = dot(&varies, &varies);
        if size <= 1e-12 * dot(&own, &own) {
            return false;
        }
        let known = [
            vec![rows(&|t| t.raw.force.clone())],
            vec![rows(&|t| t.x.clone())],
            vec![rows(&|t| t.v.clone())],
            vec![rows(&|t| (0..t.len()).map(|i| t.time(i)).collect())],
        ];
        known.into_iter().all(|mut columns| {
            columns.push(one.clone());
            let rest = Basis::of(&columns).project_out(&own);
            dot(&rest, &rest) > (1.0 - OWN) * size
        })
    }

    /// Columns of a curve over it, and of one that multiplies the direction.
    pub fn curves(&self, design: &DesignMatrix) -> Vec<Vec<Vec<f64>>> {
        let knots = self.knots(design).into_iter();
        knots.flat_map(|knots| [false, true].map(|way| self.curve(design, &knots, way))).collect()
    }

    /// Knots of a curve over it; None where it does not change.
    fn knots(&self, design: &DesignMatrix) -> Option<Vec<f64>> {
        let all: Vec<f64> = design.tracks.iter().flat_map(|t| self.at(t)).collect();
        let mut knots: Vec<f64> = (0..KNOTS).map(|k| quantile(&all, k as f64 / (KNOTS - 1) as f64)).collect();
        let span = knots[KNOTS - 1] - knots[0];
        knots.dedup_by(|a, b| (*a - *b).abs() <= 1e-3 * span);
        (knots.len() >= 2).then_some(knots)
    }

    /// Columns of the curve, one for each knot but the first, which is what the others leave: a constant is in the baseline.
    fn curve(&self, design: &DesignMatrix, knots: &[f64], with_direction: bool) -> Vec<Vec<f64>> {
        let values: Vec<Vec<f64>> = design.tracks.iter().map(|t| self.at(t)).collect();
        let hat = |k: usize, x: f64| {
            let up = k.checked_sub(1).map_or(1.0, |j| (x - knots[j]) / (knots[k] - knots[j]));
            let down = knots.get(k + 1).map_or(1.0, |next| (next - x) / (next - knots[k]));
            up.min(down).clamp(0.0, 1.0)
        };
        let of_knot = |k: usize| {
            let mut column = Vec::with_capacity(design.share.len());
            for (track, values) in design.tracks.iter().zip(&values) {
                let way = |i: usize| if with_direction { track.sign[i] } else { 1.0 };
                let series: Vec<f64> = values.iter().enumerate().map(|(i, x)| way(i) * hat(k, *x)).collect();
                track.rows(&track.pass(&series), &mut column);
            }
            column
        };
        (1..knots.len()).map(of_knot).collect()
    }
}

impl Followed {
    /// Lowest and highest value of the column.
    pub fn range(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    /// Columns that its curve adds to the baseline.
    pub fn columns_added(&self) -> usize {
        self.kept.len()
    }

    /// The columns of its curve on another design matrix; zero where the recordings lack the column.
    pub fn columns(&self, design: &DesignMatrix, extra: &[ExtraColumn]) -> Vec<Vec<f64>> {
        let Some(column) = extra.iter().find(|c| c.name == self.name) else {
            return vec![vec![0.0; design.share.len()]; self.kept.len()];
        };
        let mut all = column.curve(design, &self.knots, self.with_direction);
        self.kept.iter().map(|k| std::mem::take(&mut all[*k])).collect()
    }
}

/// Adds to the baseline a curve over each column that its error follows, the strongest first.
pub fn follow(design: &mut DesignMatrix, columns: &[ExtraColumn], seed: u64) -> Vec<Followed> {
    let own: Vec<&ExtraColumn> = columns.iter().filter(|c| c.is_own(design)).collect();
    let mut out: Vec<Followed> = Vec::new();
    let Some(mut before) = fit(&design.baseline, &design.y, &design.blocks, FOLDS) else { return out };
    while out.len() < MOST {
        let trials = own.iter().flat_map(|c| [(*c, false), (*c, true)]);
        let tried = trials.filter_map(|(column, with_direction)| {
            let knots = column.knots(design)?;
            let mut basis = Basis::of(&design.baseline);
            let curve = column.curve(design, &knots, with_direction);
            let kept: Vec<usize> = (0..curve.len()).filter(|k| basis.push(&curve[*k])).collect();
            let fresh: Vec<Vec<f64>> = kept.iter().map(|k| curve[*k].clone()).collect();
            let all: Vec<&[f64]> = design.baseline.iter().chain(&fresh).map(Vec::as_slice).collect();
            let after = fit(&all, &design.y, &design.blocks, FOLDS)?;
            let name = column.name.clone();
            let rms = (design.rms(before.heldout_sum()), design.rms(after.heldout_sum()));
            let followed = Followed { name, with_direction, knots, kept, rms, gain: [0.0; 2] };
            (!fresh.is_empty()).then_some((after, fresh, followed))
        });
        let best = tried.min_by(|a, b| a.0.heldout_sum().total_cmp(&b.0.heldout_sum()));
        let Some((after, fresh, followed)) = best else { break };
        let gain = gain_interval(
            &before.heldout,
            &after.heldout,
            &design.block_weight(),
            &design.blocks.recordings,
            1000,
            seed,
        );
        if gain[0] <= 0.0 || after.heldout_sum() > (1.0 - MATERIAL) * before.heldout_sum() {
            break;
        }
        out.push(Followed { gain, ..followed });
        design.baseline.extend(fresh);
        before = after;
    }
    out
}
