//! Faults of the clock, and values that are not numbers.

use super::fault::{FaultKind, RecordingFault};
use crate::{Basis, Recording, dot};

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

/// A number of samples, with its verb.
pub(super) fn samples(n: f64) -> String {
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

/// Misfit over the sample numbers, as a share of that over the stamps, below which the stamps are a host's.
const SMOOTHER: f64 = 0.7;
/// Steps that vary by less than this share of the period are no trouble.
const TROUBLE: f64 = 0.02;
/// Samples of a local parabola, and parabolas looked at.
const WINDOW: usize = 7;
const WINDOWS: usize = 20_000;

/// Times of samples that were taken evenly and stamped by a host when it came to it: those of the regression of the stamps on
/// the sample numbers, with the standard deviation of the stamps about them, s. None where the position is as smooth over the
/// stamps as over the numbers, so that the samples are where the stamps are, or where samples are missing.
#[must_use]
pub fn regressed(recording: &Recording) -> Option<(Vec<f64>, f64)> {
    let (time, position) = (&recording.time, &recording.position);
    let n = time.len();
    let dt = recording.sample_period()?;
    if n < crate::stretches::SHORTEST || position.len() != n || !time.iter().all(|t| t.is_finite()) {
        return None;
    }
    // a sample that was written twice has its stamp twice
    if time.windows(2).any(|w| w[1] <= w[0]) {
        return None;
    }
    let middle = 0.5 * (n - 1) as f64;
    let mean = time.iter().sum::<f64>() / n as f64;
    let (along, square) = time.iter().enumerate().fold((0.0, 0.0), |(along, square), (i, t)| {
        let k = i as f64 - middle;
        (along + k * (t - mean), square + k * k)
    });
    let period = along / square;
    let even: Vec<f64> = (0..n).map(|i| mean + period * (i as f64 - middle)).collect();
    let late = || time.iter().zip(&even).map(|(t, e)| t - e);
    // a sample that is missing moves all stamps behind it
    if !(period > 0.0) || late().any(|l| l.abs() > 3.0 * dt) {
        return None;
    }
    let std = (late().map(|l| l * l).sum::<f64>() / n as f64).sqrt();
    if std < TROUBLE * dt {
        return None;
    }
    let over = |at: &[f64]| -> f64 {
        let step = (n / WINDOWS).max(1);
        let windows = (0..=n - WINDOW).step_by(step);
        windows
            .map(|i| misfit(&at[i..i + WINDOW], &position[i..i + WINDOW], dt))
            .filter(|m| m.is_finite())
            .sum()
    };
    (over(&even) < SMOOTHER * over(time)).then_some((even, std))
}

/// Squares that the best parabola leaves of `values` at the times `at`.
fn misfit(at: &[f64], values: &[f64], dt: f64) -> f64 {
    let middle = at[at.len() / 2];
    let powers =
        [0, 1, 2].map(|power| at.iter().map(|t| ((t - middle) / dt).powi(power)).collect::<Vec<f64>>());
    let left = Basis::of(&powers).project_out(values);
    dot(&left, &left)
}

/// Says that the stamps are a host's, and takes back the gaps that they seemed to have.
pub(super) fn stamped_by_a_host(recording: &Recording, dt: f64, out: &mut Vec<RecordingFault>) {
    let Some((even, std)) = regressed(recording) else { return };
    let period = (even[even.len() - 1] - even[0]) / (even.len() - 1) as f64;
    let why = format!(
        "the stamps scatter by {:.1} % of {dt:.6} s about even times, and the position is smooth over the sample numbers: the \
         samples are even and a host stamped them; their times are those of the regression, {period:.7} s apart",
        100.0 * std / dt
    );
    let first = |f: &RecordingFault| matches!(f.kind, FaultKind::IrregularClock | FaultKind::LostSamples);
    let at = out.iter().position(first).unwrap_or(out.len());
    out.retain(|f| !first(f));
    out.insert(at.min(out.len()), RecordingFault::new(FaultKind::IrregularClock, None, why));
}
