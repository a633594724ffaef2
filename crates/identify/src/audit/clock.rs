//! Faults of the clock, and values that are not numbers.

use super::{FaultKind, RecordingFault};
use crate::Recording;
use crate::noise::noise_variance;
use crate::stretches::Stretch;

/// Gaps that are reported one by one.
const ONE_BY_ONE: usize = 8;

/// One fault for each column that has values which are not numbers.
pub(super) fn not_a_number(recording: &Recording, out: &mut Vec<RecordingFault>) {
    for (name, values) in recording.columns() {
        let mut bad = values.iter().enumerate().filter(|(_, x)| !x.is_finite());
        let Some((first, value)) = bad.next() else { continue };
        let more = bad.count();
        let also = if more == 0 { String::new() } else { format!(", and {more} more") };
        out.push(RecordingFault::new(
            FaultKind::NotANumber,
            recording.time.get(first).copied(),
            format!("{name} is {value} in sample {first}{also}"),
        ));
    }
}

/// Steps of the clock: backward, uneven, or over samples that are missing.
pub(super) fn steps(recording: &Recording, dt: f64, out: &mut Vec<RecordingFault>) {
    let time: Vec<f64> = recording.time.iter().copied().filter(|t| t.is_finite()).collect();
    let steps: Vec<(f64, f64)> = time.windows(2).map(|w| (w[0], (w[1] - w[0]) / dt)).collect();
    let backward: Vec<&(f64, f64)> = steps.iter().filter(|(_, s)| *s <= 1e-6).collect();
    if let Some((at, step)) = backward.first() {
        let why = format!("time goes on by {:.6} s here, {} such steps in all", step * dt, backward.len());
        out.push(RecordingFault::new(FaultKind::ClockBackward, Some(*at), why));
    }
    // Between two samples that follow each other; a step over missing ones is a multiple of the period.
    let uneven: Vec<f64> =
        steps.iter().filter(|(_, s)| *s > 1e-6 && *s < 1.5).map(|(_, s)| s - 1.0).collect();
    let jitter = (uneven.iter().map(|d| d * d).sum::<f64>() / uneven.len().max(1) as f64).sqrt();
    let odd: Vec<&(f64, f64)> =
        steps.iter().filter(|(_, s)| *s >= 1.5 && *s < 10.0 && (s - s.round()).abs() > 0.2).collect();
    if jitter > 0.05 || odd.len() * 50 > steps.len() {
        let why = format!(
            "steps of the clock vary by {:.1} % of {dt:.6} s (root mean square){}",
            100.0 * jitter,
            if odd.is_empty() { String::new() } else { format!(", {} are no multiple of it", odd.len()) }
        );
        out.push(RecordingFault::new(FaultKind::IrregularClock, None, why));
    }
    // Where the steps vary by themselves, a gap is what stands out of that.
    let threshold = 1.5 + 4.0 * jitter;
    // A step forward that makes good for one backward is no gap.
    let after_back = |i: usize| i > 0 && steps[i - 1].1 <= 1e-6;
    let gaps: Vec<&(f64, f64)> = steps
        .iter()
        .enumerate()
        .filter(|(i, (_, s))| *s > threshold && !after_back(*i))
        .map(|(_, g)| g)
        .collect();
    let lost = |s: f64| (s.round() - 1.0).max(1.0);
    for (at, step) in gaps.iter().take(ONE_BY_ONE) {
        let why = format!("{} missing after {at:.6} s", samples(lost(*step)));
        out.push(RecordingFault::new(FaultKind::LostSamples, Some(at + dt), why));
    }
    if let Some((at, _)) = gaps.get(ONE_BY_ONE) {
        let all: f64 = gaps.iter().skip(ONE_BY_ONE).map(|(_, s)| lost(*s)).sum();
        let why = format!("{} missing in {} further gaps", samples(all), gaps.len() - ONE_BY_ONE);
        out.push(RecordingFault::new(FaultKind::LostSamples, Some(at + dt), why));
    }
}

fn samples(n: f64) -> String {
    if n == 1.0 { "1 sample is".into() } else { format!("{n:.0} samples are") }
}

/// The period that the file declares.
pub(super) fn declared(recording: &Recording, dt: f64, out: &mut Vec<RecordingFault>) {
    for (key, value) in &recording.metadata {
        let Some(number) = value.split_whitespace().next().and_then(|v| v.parse::<f64>().ok()) else {
            continue;
        };
        let period = match key.as_str() {
            "sample_period_s" | "period_s" | "dt_s" => number,
            "sample_rate_hz" | "rate_hz" | "sampling_rate_hz" => 1.0 / number,
            _ => continue,
        };
        if period > 0.0 && period.is_finite() && (dt / period - 1.0).abs() > 0.01 {
            let why = format!(
                "time_s goes on by {dt:.6} s a sample, {key} = {value} means {period:.6} s: a factor of {:.4}",
                dt / period
            );
            out.push(RecordingFault::new(FaultKind::TimeBase, None, why));
        }
    }
}

/// Samples that are missing although the times were numbered anew: the body moves on by several samples' worth at
/// once.
pub(super) fn renumbered(recording: &Recording, stretch: &Stretch, out: &mut Vec<RecordingFault>) {
    let Some(position) = recording.position.get(stretch.range.clone()) else { return };
    let time = &recording.time[stretch.range.clone()];
    let noise = noise_variance(position).sqrt();
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut last = 0;
    for i in 4..position.len().saturating_sub(5) {
        let step = |k: usize| position[k + 1] - position[k];
        // Steps before and after, the nearest two on either side left out of a jump's own reach.
        let before = (position[i] - position[i - 4]) / 4.0;
        let after = (position[i + 5] - position[i + 1]) / 4.0;
        let usual = 0.5 * (before + after);
        if usual.abs() < 4.0 * noise || (before - after).abs() > 0.3 * usual.abs() {
            continue;
        }
        let spread = (i - 4..i).chain(i + 1..i + 5).map(|k| (step(k) - usual).abs()).fold(noise, f64::max);
        let share = step(i) / usual;
        // a step has √2 of the noise, and a recording has tens of thousands of them
        let excess = step(i) - usual;
        if share > 1.7 && (share - share.round()).abs() < 0.3 && excess.abs() > 6.0 * spread && i > last + 4 {
            found.push((time[i], share.round() - 1.0));
            last = i;
        }
    }
    // Often: not samples that were lost but a channel that is updated less often than it is recorded.
    if found.len() * 100 > position.len() {
        return;
    }
    for (at, lost) in found.iter().take(ONE_BY_ONE) {
        let why = format!(
            "the position goes on by {:.0} samples' worth after {at:.6} s although the clock does not: {} missing",
            lost + 1.0,
            samples(*lost)
        );
        out.push(RecordingFault::new(FaultKind::LostSamples, Some(at + stretch.dt), why));
    }
}
