//! A force channel whose zero drifts: taken out before anything is named, because a force that changes with time without
//! asking for the direction is the amplifier's, and friction that changes with time is not.
//!
//! The straight line in time is fitted jointly with the baseline, forces along the stroke of either kind, and friction
//! that changes with time, so that it takes only what none of them explains. A zero that steps once, for example because the load
//! cell was knocked, is not a drift: taking a line out would leave a sawtooth.

use crate::free_form::change;
use crate::library::design_matrix::DesignMatrix;
use crate::preparation::track::Track;
use crate::regression::linear::{FOLDS, fit};
use signals::{Basis, dot};

/// Slope over its standard deviation that counts.
const MIN_T_STATISTIC: f64 = 5.0;
/// Root mean square of the line over the noise floor that matters.
const MATTERS: f64 = 0.3;

/// The drift of one recording's force channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Index of the recording.
    pub recording: usize,
    /// N/s or N·m/s, with its standard deviation.
    pub slope: (f64, f64),
    /// Time at which the line is zero, s.
    pub middle: f64,
    /// Length of the recording, s.
    pub duration: f64,
}

/// Recordings of which the force channel drifts, `recordings` of them.
pub fn find(design: &DesignMatrix, recordings: usize) -> Vec<Drift> {
    (0..recordings).filter_map(|r| of(design, r)).collect()
}

fn of(design: &DesignMatrix, recording: usize) -> Option<Drift> {
    let own = |t: &Track| t.raw.recording == recording;
    let times = design.tracks.iter().filter(|t| own(t)).map(|t| (t.time(0), t.time(t.len())));
    let (from, to) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (c, d)| (a.min(c), b.max(d)));
    if !(to > from) || design.is_one_way() {
        return None;
    }
    let middle = 0.5 * (from + to);
    let column = |of: &dyn Fn(&Track, usize) -> f64| {
        design.rows(|t| t.pass(&(0..t.len()).map(|i| of(t, i)).collect::<Vec<_>>()))
    };
    let time = |t: &Track, i: usize| if own(t) { t.time(i) - middle } else { 0.0 };
    let mut columns: Vec<Vec<f64>> = design.baseline[..5].to_vec();
    columns.push(column(&|t, i| time(t, i)));
    columns.push(column(&|t, i| t.sign[i] * time(t, i)));
    columns.push(column(&|t, i| t.x[i]));
    columns.push(column(&|t, i| t.x[i].powi(2)));
    columns.push(column(&|t, i| t.x[i].powi(3)));
    columns.push(column(&|t, i| t.sign[i] * t.x[i]));
    let found = fit(&columns, &design.y, &design.blocks, FOLDS)?;
    let slope = (found.coefficients[5], found.std_errors()[5]);
    let duration = to - from;
    let noise =
        design.tracks.iter().map(|t| t.noise.force * t.filter.white_gain(t.stride)).fold(0.0, f64::max);
    let matters = slope.0.abs() * duration / 12f64.sqrt() > MATTERS * noise;
    if !matters || slope.0.abs() <= MIN_T_STATISTIC * slope.1 {
        return None;
    }
    let line = columns.remove(5);
    let zero = column(&|t, _| if own(t) { 1.0 } else { 0.0 });
    let steps = is_rather_a_step(&line, &zero, &Basis::of(&columns), design);
    (!steps).then_some(Drift { recording, slope, middle, duration })
}

/// Whether a zero that steps at one moment explains more than a line in time, beside what spans `basis`. `zero` is the column of a
/// constant force in the recording.
fn is_rather_a_step(line: &[f64], zero: &[f64], basis: &Basis, design: &DesignMatrix) -> bool {
    let left = basis.project_out(&design.y);
    let explained = |column: &[f64]| {
        let beside = basis.project_out(column);
        dot(&beside, &left).powi(2) / dot(&beside, &beside).max(1e-300)
    };
    let there = |row: &usize| zero.get(*row).is_some_and(|z| *z > 0.0);
    let edges: Vec<usize> = design.blocks.edges.iter().copied().filter(there).collect();
    change::best(zero, basis, &left, &edges, |_| true)
        .is_some_and(|row| explained(&change::from(zero, row)) > explained(line))
}
