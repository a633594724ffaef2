//! Interpolation over short gaps: a few samples of motion and force follow from their neighbours.

use crate::{FaultKind, Recording, RecordingFault};

/// Longest run of samples that is filled in.
const LONGEST: usize = 4;

/// Steps of the clock from which on a sample is missing.
const GAP: f64 = 1.6;

/// Steps of the clock below which a sample was written twice.
const AGAIN: f64 = 0.05;

/// A recording with its short gaps closed.
#[derive(Debug, Clone)]
pub struct Bridged {
    /// The recording, its columns still of equal length.
    pub recording: Recording,
    /// Where each sample of the original is in it.
    pub places: Vec<usize>,
    /// Says in how many samples something was put in, where it was.
    pub fault: Option<RecordingFault>,
}

/// Puts samples into gaps of the clock of at most four, and values for as many in a row that are not numbers: cubics through
/// the two on either side. Longer gaps stay; of a sample that was written twice the first counts. Columns of unequal length
/// end as values that are not numbers.
#[must_use]
pub fn bridged(recording: &Recording) -> Bridged {
    let dt = recording.sample_period().unwrap_or(f64::NAN);
    let (mut time, mut places): (Vec<f64>, Vec<usize>) = (Vec::new(), Vec::new());
    for t in &recording.time {
        let before = time.last().copied();
        let steps = before.map_or(1.0, |before| (t - before) / dt);
        let before = before.unwrap_or(*t);
        if (0.0..AGAIN).contains(&steps) {
            places.push(time.len() - 1);
            continue;
        }
        let missing = steps.round() - 1.0;
        if steps >= GAP && missing <= LONGEST as f64 {
            time.extend((1..=missing as usize).map(|k| before + (t - before) * k as f64 / (missing + 1.0)));
        }
        places.push(time.len());
        time.push(*t);
    }
    let mut touched = vec![false; time.len()];
    let mut spread = |column: &[f64]| {
        let mut out = vec![f64::NAN; time.len()];
        // of what was written twice the first
        for (place, value) in places.iter().zip(column).rev() {
            out[*place] = *value;
        }
        for i in fill(&time, &mut out) {
            touched[i] = true;
        }
        out
    };
    let mut optional = |column: &Option<Vec<f64>>| column.as_deref().map(&mut spread);
    let recording = Recording {
        name: recording.name.clone(),
        geometry: recording.geometry,
        velocity: optional(&recording.velocity),
        acceleration: optional(&recording.acceleration),
        normal_force: optional(&recording.normal_force),
        command: optional(&recording.command),
        reference: optional(&recording.reference),
        temperature: optional(&recording.temperature),
        position: spread(&recording.position),
        force: spread(&recording.force),
        time,
        // of the original recording: nothing behind this reads them
        extra: std::collections::BTreeMap::new(),
        metadata: recording.metadata.clone(),
        remarks: recording.remarks.clone(),
    };
    let filled = touched.into_iter().filter(|t| *t).count();
    let why = format!("{filled} samples in gaps of at most four are put in from those on either side");
    let fault = (filled > 0).then(|| RecordingFault::new(FaultKind::LostSamples, None, why));
    Bridged { recording, places, fault }
}

/// Replaces runs of at most [`LONGEST`] values that are not numbers by the cubic through the two on either side, where all
/// four stand together; by a straight line where they do not. Returns which.
fn fill(time: &[f64], column: &mut [f64]) -> Vec<usize> {
    let mut filled = Vec::new();
    let known: Vec<usize> = (0..column.len()).filter(|i| column[*i].is_finite()).collect();
    for (k, pair) in known.windows(2).enumerate() {
        let (low, high) = (pair[0], pair[1]);
        if high - low < 2 || high - low > LONGEST + 1 {
            continue;
        }
        let mut nodes = vec![low, high];
        let beside = (k.checked_sub(1).and_then(|b| known.get(b)), known.get(k + 2));
        if let (Some(before), Some(after)) = beside
            && before + 1 == low
            && *after == high + 1
        {
            nodes = vec![*before, low, high, *after];
        }
        for i in low + 1..high {
            column[i] = lagrange(time, column, &nodes, time[i]);
            filled.push(i);
        }
    }
    filled
}

/// The polynomial through `nodes`, at `t`.
fn lagrange(time: &[f64], column: &[f64], nodes: &[usize], t: f64) -> f64 {
    let others = |a: &usize| -> f64 {
        let rest = nodes.iter().filter(|b| *b != a);
        rest.map(|b| (t - time[*b]) / (time[*a] - time[*b])).product()
    };
    nodes.iter().map(|a| column[*a] * others(a)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_with_lost_samples_and_holes_comes_back_and_a_long_gap_stays() {
        let at = |t: f64| 1.0 + 2.0 * t - 30.0 * t * t + 400.0 * t * t * t;
        let lost = |i: &usize| ![20, 21, 40, 41, 42, 43].contains(i) && !(60..70).contains(i);
        let time: Vec<f64> = (0..100).filter(lost).map(|i| 1e-3 * i as f64).collect();
        let mut position: Vec<f64> = time.iter().map(|t| at(*t)).collect();
        let hole = 8;
        position[hole] = f64::NAN;
        // the tenth was written twice
        let mut time = time;
        time.insert(10, time[10]);
        position.insert(11, -5.0);
        let recording = Recording {
            force: vec![1.0; time.len()],
            velocity: Some(vec![1.0; time.len()]),
            time,
            position,
            ..Recording::default()
        };
        let Bridged { recording: whole, places, fault } = bridged(&recording);
        assert_eq!(whole.len(), 90);
        assert!(fault.is_some_and(|f| f.why.starts_with("7 samples ")));
        for (t, x) in whole.time.iter().zip(&whole.position) {
            assert!((x - at(*t)).abs() < 1e-12, "{t} s: {x} for {}", at(*t));
        }
        assert!(whole.velocity.unwrap().iter().all(|v| (v - 1.0).abs() < 1e-12));
        for (i, place) in places.iter().enumerate() {
            assert_eq!(whole.time[*place], recording.time[i]);
            assert!(i == 11 || i == hole || whole.position[*place] == recording.position[i]);
        }
    }
}
