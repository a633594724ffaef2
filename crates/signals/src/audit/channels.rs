//! Faults that a channel shows by its values alone.

use super::fault::{FaultKind, RecordingFault};
use crate::Recording;
use crate::noise::{noise_variance, quantum};

/// Samples in a row at the rail that chance does not give.
const RUN: usize = 5;

/// Channels that stand still, sit at a rail, or are coarse.
pub(super) fn values(recording: &Recording, out: &mut Vec<RecordingFault>) {
    for (name, values) in recording.columns() {
        let moving = name.starts_with("position") || name.starts_with("velocity");
        let measured = moving || ["force", "torque", "acceleration"].iter().any(|q| name.starts_with(q));
        if !measured || values.len() < 2 {
            continue;
        }
        let finite = values.iter().filter(|x| x.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        if !(high > low) {
            if low.is_finite() && !name.starts_with("position") {
                let why = format!("{name} is {low} in every sample");
                out.push(RecordingFault::new(FaultKind::ConstantChannel, None, why));
            }
            continue;
        }
        if !name.starts_with("position") {
            rails(recording, name, values, [low, high], out);
        }
        let step = quantum(values);
        let rms = spread(values);
        let often = repeats(values);
        if step > 0.05 * rms && often > 0.05 {
            let floor = step / 12f64.sqrt();
            let why = format!(
                "{name} has steps of {step:.4e}, its root mean square is {rms:.4e}: whatever happens between two steps, its \
                 error is {floor:.4e}"
            );
            out.push(RecordingFault::new(FaultKind::Quantisation, None, why));
        }
    }
}

/// Runs of samples at the largest or the smallest value.
fn rails(recording: &Recording, name: &str, values: &[f64], ends: [f64; 2], out: &mut Vec<RecordingFault>) {
    let range = ends[1] - ends[0];
    let step = quantum(values);
    // A coarse channel rests at the top of a slow wave without being clipped.
    if step > 0.01 * range {
        return;
    }
    for (rail, which) in ends.into_iter().zip(["smallest", "largest"]) {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        let mut start = None;
        for i in 0..=values.len() {
            let there = values.get(i).is_some_and(|x| (x - rail).abs() <= 1e-9 * range);
            match (there, start) {
                (true, None) => start = Some(i),
                (false, Some(s)) => {
                    if i - s >= RUN {
                        runs.push((s, i - s));
                    }
                    start = None;
                }
                _ => {}
            }
        }
        let samples: usize = runs.iter().map(|(_, n)| n).sum();
        let Some((first, longest)) =
            runs.first().map(|(s, _)| (*s, runs.iter().map(|(_, n)| *n).max().unwrap_or(0)))
        else {
            continue;
        };
        // Before the first motion a channel may rest; only a rail that is come to from elsewhere counts.
        let come_to = runs.iter().any(|(s, n)| {
            let near = 0.5 * range;
            *s > 0 && (values[s - 1] - rail).abs() < near && s + n < values.len()
        });
        if come_to && (runs.len() >= 2 || longest >= 4 * RUN) {
            let why = format!(
                "{name} is at its {which} value, {rail}, for {samples} samples, up to {longest} in a row"
            );
            out.push(RecordingFault::new(FaultKind::Saturation, recording.time.get(first).copied(), why));
        }
    }
}

/// The body hardly moves.
pub(super) fn motion(recording: &Recording, out: &mut Vec<RecordingFault>) {
    let position = &recording.position;
    let mut sorted: Vec<f64> = position.iter().copied().filter(|x| x.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let aside = sorted.len() / 200;
    let (Some(low), Some(high)) = (sorted.get(aside), sorted.iter().rev().nth(aside)) else { return };
    let error = noise_variance(position).sqrt().max(quantum(position));
    let travel = high - low;
    if !(travel > 20.0 * error) {
        let why = format!(
            "the position moves over {travel:.4e}; its noise and steps are {error:.4e}, and 20 times that are needed"
        );
        out.push(RecordingFault::new(FaultKind::TooLittleMotion, None, why));
    }
}

/// Standard deviation.
fn spread(values: &[f64]) -> f64 {
    let finite = || values.iter().filter(|x| x.is_finite());
    let n = finite().count().max(1) as f64;
    let mean = finite().sum::<f64>() / n;
    (finite().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// Share of samples that equal the one before.
fn repeats(values: &[f64]) -> f64 {
    values.windows(2).filter(|w| w[0] == w[1]).count() as f64 / values.len().max(1) as f64
}
