//! What may differ from one recording of a body to the next without being physics: a zero of the force channel, of the
//! encoder, the friction level of the day. Shared unless declared: every one that is free can hide physics.
//!
//! Offset and friction level are columns of the fit, relative to the first recording, because a constant common to all is
//! the asymmetry of Coulomb friction, and a level common to all is Coulomb friction. The origin of the position is found
//! before anything is named, by registration: any law of position, even or odd in the direction, is a curve over
//! position that the recordings must share.

use crate::experiment::evidence::left;
use crate::findings::locate::row_motion;
use crate::library::applied_force::AppliedForce;
use crate::library::design_matrix::DesignMatrix;
use crate::per_recording::Nuisance;
use crate::regression::linear::fit;
use nalgebra::{DMatrix, DVector};

/// A nuisance that is a column of the baseline, and of which recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Declared {
    pub recording: usize,
    pub nuisance: Nuisance,
}

impl DesignMatrix {
    /// Column of a nuisance, zero outside of `recording` where one is given. None for the origin.
    pub(crate) fn nuisance_column(&self, nuisance: Nuisance, recording: Option<usize>) -> Option<Vec<f64>> {
        nuisance.column(&[])?;
        Some(self.rows(|t| match nuisance.column(&t.sign) {
            Some(series) if recording.is_none_or(|r| r == t.raw.recording) => t.pass(&series),
            _ => vec![0.0; t.len()],
        }))
    }

    /// Adds the columns of `declared` nuisances for every recording after the first.
    pub(crate) fn declare(&mut self, declared: &[Nuisance]) -> Vec<Declared> {
        let first = self.tracks.first().map_or(0, |t| t.raw.recording);
        let mut recordings: Vec<usize> = self.tracks.iter().map(|t| t.raw.recording).collect();
        recordings.dedup();
        let mut out = Vec::new();
        for &recording in recordings.iter().filter(|r| **r != first) {
            for &nuisance in declared {
                let column = self.nuisance_column(nuisance, Some(recording));
                if let Some(column) = column.filter(|c| c.iter().any(|x| *x != 0.0)) {
                    self.baseline.push(column);
                    out.push(Declared { recording, nuisance });
                }
            }
        }
        if let Some(fit) = (!out.is_empty()).then(|| fit(&self.baseline, &self.y, &self.blocks, 4)).flatten()
        {
            self.blocks.mass = fit.coefficients[0];
            let acting = AppliedForce::baseline(self.physics(&fit.coefficients));
            self.model_force(&acting);
        }
        out
    }

    /// The same design matrix with every position less by `by` in one recording.
    pub(crate) fn shifted(&self, recording: usize, by: f64) -> Self {
        let mut out = self.clone();
        for track in out.tracks.iter_mut().filter(|t| t.raw.recording == recording) {
            track.x.iter_mut().for_each(|x| *x -= by);
            track.raw.position.iter_mut().for_each(|x| *x -= by);
        }
        out
    }
}

/// Knots of the curve over position.
const KNOTS: usize = 28;
/// Places tried over the range of a shift.
const PLACES: i32 = 40;
/// Squared error, in squared noise, by which one shift must be better than another to be preferred.
pub(crate) const MIN_CHI_SQUARE: f64 = 30.0;

/// Where position is zero in each recording after the first, relative to it, with its standard deviation; None where the
/// recordings do not determine it.
pub(crate) fn origins(design: &DesignMatrix) -> Vec<(usize, Option<(f64, f64)>)> {
    let (mut position, _) = row_motion(design);
    let sign = design.rows(|t| t.sign.clone());
    let mut owner = Vec::new();
    for track in &design.tracks {
        owner.extend(std::iter::repeat_n(track.raw.recording, track.row_count()));
    }
    let mut recordings = owner.clone();
    recordings.dedup();
    let mut out = Vec::new();
    for k in 1..recordings.len() {
        let rows: Vec<usize> = (0..owner.len())
            .filter(|&i| recordings[..=k].contains(&owner[i]) && design.share[i] > 0.5)
            .collect();
        let here = recordings[k];
        let found = register(design, &rows, &position, &sign, |i| owner[i] == here);
        if let Some((shift, _)) = found {
            for (x, _) in position.iter_mut().zip(&owner).filter(|(_, o)| **o == here) {
                *x -= shift;
            }
        }
        out.push((here, found));
    }
    out
}

/// The shift of some rows at which one curve over position serves all best.
fn register(
    design: &DesignMatrix,
    rows: &[usize],
    position: &[f64],
    sign: &[f64],
    moved: impl Fn(usize) -> bool,
) -> Option<(f64, f64)> {
    let range = |want: bool| {
        rows.iter()
            .filter(|&&i| moved(i) == want)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &i| (l.min(position[i]), h.max(position[i])))
    };
    let (old, new) = (range(false), range(true));
    let span = (old.1 - old.0).min(new.1 - new.0);
    if !(span > 0.0 && span.is_finite()) {
        return None;
    }
    let (low, high) = (old.0.min(new.0), old.1.max(new.1));
    let reach = 0.5 * span;
    let error = |shift: f64| -> f64 {
        let place = |i: usize| {
            let x = if moved(i) { position[i] - shift } else { position[i] };
            // beyond either end the curve goes on level
            ((x - low + reach) / (high - low + 2.0 * reach) * (KNOTS - 1) as f64)
                .clamp(0.0, KNOTS as f64 - 1.001)
        };
        let p = design.baseline.len() + 2 * KNOTS;
        let mut gram = DMatrix::zeros(p, p);
        let mut moment = DVector::zeros(p);
        let mut power = 0.0;
        let mut entries: Vec<(usize, f64)> = Vec::with_capacity(design.baseline.len() + 4);
        for &i in rows {
            entries.clear();
            entries.extend(design.baseline.iter().enumerate().map(|(c, column)| (c, column[i])));
            let at = place(i);
            let (knot, share) = (at.floor() as usize, at.fract());
            let way = sign[i].signum() * design.share[i];
            let from = design.baseline.len() + knot;
            entries.extend([
                (from, (1.0 - share) * design.share[i]),
                (from + 1, share * design.share[i]),
                (from + KNOTS, (1.0 - share) * way),
                (from + KNOTS + 1, share * way),
            ]);
            for &(a, x) in &entries {
                for &(b, y) in &entries {
                    gram[(a, b)] += x * y;
                }
                moment[a] += x * design.y[i];
            }
            power += design.y[i] * design.y[i];
        }
        left(&gram, &moment, power)
    };
    let still = error(0.0);
    let freedom = (rows.len() as f64 - (design.baseline.len() + 2 * KNOTS) as f64).max(1.0);
    let (best, least) = nearest(reach, span, |least| MIN_CHI_SQUARE * least / freedom, error);
    let step = 2.0 * reach / f64::from(PLACES);
    let noise = least / freedom;
    if !(still - least > MIN_CHI_SQUARE * noise) {
        return None;
    }
    let h = 0.25 * step;
    let bend = (error(best + h) + error(best - h) - 2.0 * least) / (h * h);
    let std = if bend > 0.0 { (2.0 * noise / bend).sqrt() } else { f64::NAN };
    Some((best, std))
}

/// The shift within ±`reach` with the least error, and that error. Of several minima that differ by no more than
/// `slack(least)` it is the one nearest to zero: a wave over position repeats, and its origin with it.
pub(crate) fn nearest(
    reach: f64,
    span: f64,
    slack: impl Fn(f64) -> f64,
    error: impl Fn(f64) -> f64,
) -> (f64, f64) {
    let step = 2.0 * reach / f64::from(PLACES);
    let coarse: Vec<(f64, f64)> =
        (-PLACES / 2..=PLACES / 2).map(|k| f64::from(k) * step).map(|s| (s, error(s))).collect();
    let lowest = |k: usize| {
        let beside = [k.checked_sub(1), Some(k + 1)];
        beside.into_iter().flatten().filter_map(|j| coarse.get(j)).all(|c| c.1 >= coarse[k].1)
    };
    let refined = |(mut best, mut least): (f64, f64)| {
        let mut width = 0.5 * step;
        while width > 1e-4 * span {
            for side in [-1.0, 1.0] {
                let there = error(best + side * width);
                if there < least {
                    (best, least) = (best + side * width, there);
                }
            }
            width *= 0.6;
        }
        (best, least)
    };
    let minima: Vec<(f64, f64)> =
        (0..coarse.len()).filter(|&k| lowest(k)).map(|k| refined(coarse[k])).collect();
    let least = minima.iter().map(|m| m.1).fold(f64::INFINITY, f64::min);
    let most = least + slack(least);
    let near = minima.into_iter().filter(|m| m.1 <= most).min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    near.unwrap_or((0.0, least))
}
