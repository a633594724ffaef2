//! Outliers: samples far from all their neighbours, as a bad contact or a lost bit makes them.

use super::fault::{FaultKind, RecordingFault};
use crate::Recording;
use crate::noise::{noise_variance, quantum};

/// Distance from the median of five that counts, in standard deviations of that distance.
const FAR: f64 = 12.0;
/// The same, as a share of the channel's spread: what is smaller does no harm and may be the body's own.
const LARGE: f64 = 0.3;
/// Distance of an outlier from its neighbour on one side over that on the other.
const ALIKE: f64 = 0.5;

/// Indices of the outliers of a channel.
///
/// At most two in a row: a plateau of three or more is something that lasted. The median of five keeps the steps that
/// dry friction makes.
fn outliers(series: &[f64]) -> Vec<usize> {
    if series.len() < 32 {
        return Vec::new();
    }
    let distance: Vec<f64> = (0..series.len())
        .map(|i| {
            // the first and the last two are compared with the five at their end
            let from = i.saturating_sub(2).min(series.len() - 5);
            let mut sorted = [0.0; 5];
            sorted.copy_from_slice(&series[from..from + 5]);
            sorted.sort_by(f64::total_cmp);
            if sorted.iter().all(|x| x.is_finite()) { series[i] - sorted[2] } else { 0.0 }
        })
        .collect();
    let quantile = |of: &mut Vec<f64>, share: f64| -> f64 {
        of.sort_by(f64::total_cmp);
        of.get(((of.len() as f64 - 1.0) * share).round().max(0.0) as usize).copied().unwrap_or(0.0)
    };
    // The sample itself is the median of a monotonic five; what is told from others is the rest.
    let mut sizes: Vec<f64> = distance.iter().map(|d| d.abs()).filter(|d| *d > 0.0).collect();
    let usual = 1.4826 * quantile(&mut sizes, 0.4);
    let mut values: Vec<f64> = series.iter().copied().filter(|x| x.is_finite()).collect();
    let spread = quantile(&mut values, 0.9) - quantile(&mut values, 0.1);
    let far = (FAR * usual.max(quantum(series))).max(LARGE * spread);
    if !(far > 0.0) {
        return Vec::new();
    }
    let is_far = |i: usize| distance.get(i).is_some_and(|d| d.abs() > far);
    (0..series.len())
        .filter(|&i| {
            let (after, before) = (
                (1..3).take_while(|k| is_far(i + k)).count(),
                (1..3).take_while(|k| i >= *k && is_far(i - k)).count(),
            );
            let to = |neighbour: Option<&f64>| neighbour.map(|x| (series[i] - x).abs());
            let to_before = to(i.checked_sub(before + 1).and_then(|j| series.get(j)));
            is_far(i) && before + after <= 1 && stands_out(to_before, to(series.get(i + after + 1)))
        })
        .collect()
}

/// Whether a sample is about as far from what was before it as from what came after, where both are there. A blow that dies out
/// is not: its first sample is far from rest, and much less from the next one.
fn stands_out(before: Option<f64>, after: Option<f64>) -> bool {
    before.zip(after).is_none_or(|(before, after)| before.min(after) > ALIKE * before.max(after))
}

/// Standard deviations by which a spike must contradict the position.
const CONTRADICTS: f64 = 4.0;

/// Changes of the velocity that are usual, in percent of all, and how many of those a blow makes.
const USUAL: usize = 99;
const BLOW: f64 = 1.5;

/// Speed over the three samples after sample `i` less that over the three before it, and the period there, s.
fn change_of_speed(recording: &Recording, i: usize) -> Option<(f64, f64)> {
    let (time, position) = (&recording.time, &recording.position);
    let before = i.checked_sub(4)?;
    let dt = (time.get(i + 4)? - time[before]) / 8.0;
    Some(((position.get(i + 4)? - position[i + 1] - position[i - 1] + position[before]) / (3.0 * dt), dt))
}

/// Samples of the acceleration that no body had: friction that lets go or catches does accelerate one for a
/// millisecond, and then the velocity has changed by as much.
fn unmoved(recording: &Recording, acceleration: &[f64]) -> Vec<usize> {
    let noise = noise_variance(&recording.position).sqrt();
    let own = noise_variance(acceleration).sqrt();
    outliers(acceleration)
        .into_iter()
        .filter(|&i| {
            let Some((change, dt)) = change_of_speed(recording, i) else { return true };
            // from the middle of the three samples before to that of the three after
            let expected: f64 = acceleration[i - 2..=i + 2].iter().sum::<f64>() * dt;
            let deviation = (2.0 * noise / (3.0 * dt)).hypot(5f64.sqrt() * own * dt);
            !((change - expected).abs() <= CONTRADICTS * deviation)
        })
        .collect()
}

/// Samples of the force that moved nothing: a blow between two samples shows in one of them, and then the velocity has
/// changed, the same way and by more than it does elsewhere.
fn without_blow(recording: &Recording, force: &[f64]) -> Vec<usize> {
    let found = outliers(force);
    if found.is_empty() {
        return found;
    }
    let change = |i: usize| Some(change_of_speed(recording, i)?.0);
    let mut usual: Vec<f64> = (0..force.len()).filter_map(change).map(f64::abs).collect();
    usual.retain(|c| c.is_finite());
    usual.sort_by(f64::total_cmp);
    let usual = usual.get(usual.len() * USUAL / 100).copied().unwrap_or(0.0);
    let moves = |i: &usize| {
        let way = |change: f64| change * (2.0 * force[*i] - force[i - 1] - force[i + 1]).signum();
        change(*i).is_some_and(|c| way(c) > BLOW * usual)
    };
    found.into_iter().filter(|i| !moves(i)).collect()
}

/// Samples at the beginning of a velocity column that an estimator without history gave: exactly 0 while the position moves
/// as fast as right after them.
fn without_history(recording: &Recording, velocity: &[f64]) -> Vec<usize> {
    let count = velocity.iter().take_while(|v| **v == 0.0).count();
    let after = count + 4;
    let (Some(next), true) = (velocity.get(count), (1..=2).contains(&count)) else { return Vec::new() };
    let (time, position) = (&recording.time, &recording.position);
    let (Some(t), Some(x)) = (time.get(..=after), position.get(..=after)) else { return Vec::new() };
    let noise = noise_variance(position).sqrt();
    let slope = |from: usize, to: usize| (x[to] - x[from]) / (t[to] - t[from]);
    let std = |from: usize, to: usize| 2f64.sqrt() * noise / (t[to] - t[from]);
    // over the samples in question, and over those after them: from rest, the first would be well below the second
    let (during, later) = (slope(0, count + 1), slope(count, after));
    let error = CONTRADICTS * std(0, count + 1).hypot(std(count, after));
    let moving = during * next > 0.0
        && during.abs() > 0.7 * later.abs() + error
        && (later - next).abs() < 0.3 * next.abs() + error;
    if moving { (0..count).collect() } else { Vec::new() }
}

/// Outliers of a column of the recording.
fn of_column(recording: &Recording, name: &str, values: &[f64]) -> Vec<usize> {
    if name.starts_with("acceleration") {
        return unmoved(recording, values);
    }
    if name.starts_with("force") || name.starts_with("torque") {
        return without_blow(recording, values);
    }
    let mut found = outliers(values);
    if name.starts_with("velocity") {
        found.extend(without_history(recording, values));
        found.sort_unstable();
        found.dedup();
    }
    found
}

/// Channels a sensor measures.
fn measured(name: &str) -> bool {
    ["position", "velocity", "acceleration", "force", "torque", "normal_force"]
        .iter()
        .any(|q| name.starts_with(q))
}

pub(super) fn far_from_neighbours(recording: &Recording, out: &mut Vec<RecordingFault>) {
    for (name, values) in recording.columns().into_iter().filter(|(name, _)| measured(name)) {
        let found = of_column(recording, name, values);
        if let Some(first) = found.first() {
            let share = 100.0 * found.len() as f64 / values.len().max(1) as f64;
            let value = values[*first];
            let why = match found.len() {
                1 => format!("{name} has a sample far from all its neighbours, {value:.4e}"),
                n => format!(
                    "{name} has {n} samples far from all their neighbours ({share:.2} %), the first {value:.4e}"
                ),
            };
            out.push(RecordingFault::new(FaultKind::Outliers, recording.time.get(*first).copied(), why));
        }
    }
}

/// The recording with every outlier replaced by the straight line between its neighbours; the audit names them.
#[must_use]
pub fn without_outliers(recording: &Recording) -> Recording {
    let mut out = recording.clone();
    let mend = |name: &str, values: &mut Vec<f64>| {
        let found = of_column(recording, name, values);
        for &i in &found {
            let before = values[..i].iter().rposition(|x| x.is_finite());
            let good = |j: &usize| values[*j].is_finite() && found.binary_search(j).is_err();
            let after = (i + 1..values.len()).find(good);
            values[i] = match (before, after) {
                (Some(b), Some(a)) => values[b] + (values[a] - values[b]) * (i - b) as f64 / (a - b) as f64,
                (Some(end), None) | (None, Some(end)) => values[end],
                (None, None) => values[i],
            };
        }
    };
    mend("position", &mut out.position);
    mend("force", &mut out.force);
    for (name, optional) in [
        ("velocity", &mut out.velocity),
        ("acceleration", &mut out.acceleration),
        ("normal_force", &mut out.normal_force),
    ] {
        if let Some(values) = optional {
            mend(name, values);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spikes_are_told_from_steps_peaks_and_noise() {
        let seed = std::cell::Cell::new(1u64);
        let noise = || {
            seed.set(
                seed.get().wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407),
            );
            (seed.get() >> 33) as f64 / 2f64.powi(31) - 0.5
        };
        let clean: Vec<f64> = (0..2000)
            .map(|i| {
                let t = f64::from(i) * 0.01;
                2.0 * t.sin().signum() + (3.0 * t).cos() + 0.2 * noise()
            })
            .collect();
        assert!(outliers(&clean).is_empty(), "{:?}", outliers(&clean));
        assert!(outliers(&vec![1.0; 100]).is_empty());
        let mut spiked = clean.clone();
        for i in [100, 500, 501, 1500] {
            spiked[i] += 30.0;
        }
        assert_eq!(outliers(&spiked), [100, 500, 501, 1500]);
        let recording = Recording { force: spiked, position: clean.clone(), ..Recording::default() };
        let mended = without_outliers(&recording);
        let worst = mended.force.iter().zip(&clean).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("worst sample after mending: {worst:.3}");
        assert!(worst < 0.5 && mended.position == clean);
        // two of opposite sign side by side were mended with each other, and the two at either end were not seen
        let mut crossed = clean.clone();
        for (i, by) in [(0, 30.0), (500, 30.0), (501, -30.0), (1998, -30.0)] {
            crossed[i] += by;
        }
        assert_eq!(outliers(&crossed), [0, 500, 501, 1998]);
        let mended = without_outliers(&Recording { force: crossed, ..Recording::default() });
        let worst = mended.force.iter().zip(&clean).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 0.5, "{worst}");
        // a jerk of a millisecond is a body's own where the velocity has changed by it, and a bad contact where not
        let jerk = |velocity_changes: bool| {
            let a: Vec<f64> = (0..2000).map(|i| if i == 1000 { 300.0 } else { noise() }).collect();
            let at = |i: i32| if velocity_changes && i > 1000 { 0.3e-3 * f64::from(i - 1000) } else { 0.0 };
            let recording = Recording {
                time: (0..2000).map(|i| f64::from(i) * 1e-3).collect(),
                position: (0..2000).map(|i| at(i) + 2e-6 * noise()).collect(),
                acceleration: Some(a.clone()),
                ..Recording::default()
            };
            of_column(&recording, "acceleration_m_s2", &a)
        };
        assert_eq!((jerk(true), jerk(false)), (vec![], vec![1000]));
        // a blow dies out, from one sample to the next or not at once
        let mut blow = clean.clone();
        blow[500..520].iter_mut().enumerate().for_each(|(k, x)| *x += 30.0 * (-(k as f64) / 4.0).exp());
        assert!(outliers(&blow).is_empty(), "{:?}", outliers(&blow));
        // and of a short one the velocity tells, which has changed by it
        let short = |moves: bool| {
            let position = (0..2000).map(|i| if moves { 0.02 * f64::from((i - 1000).max(0)) } else { 0.0 });
            let recording = Recording {
                time: (0..2000).map(|i| f64::from(i) * 1e-3).collect(),
                position: position.map(|x| x + 1e-4 * noise()).collect(),
                ..Recording::default()
            };
            let force: Vec<f64> = (0..2000).map(|i| if i == 1000 { 30.0 } else { noise() }).collect();
            of_column(&recording, "force_n", &force)
        };
        assert_eq!((short(true), short(false)), (vec![], vec![1000]));
        // a plateau is something that lasted
        let mut plateau = clean;
        plateau[700..705].fill(40.0);
        assert!(outliers(&plateau).is_empty());
    }

    #[test]
    fn the_first_velocity_of_an_estimator_without_history_was_believed() {
        // an encoder at 1 kHz, moving from the beginning or starting from rest
        let recording = |from: f64, zeros: usize| {
            let at = |i: usize| 1e-3 * i as f64 + from;
            let position = |t: f64| (0.01 * (1.0 - (6.0 * t).cos()) / 2.57e-6).round() * 2.57e-6;
            let mut velocity: Vec<f64> = (0..2000).map(|i| 0.06 * (6.0 * at(i)).sin()).collect();
            velocity[..zeros].fill(0.0);
            Recording {
                time: (0..2000).map(at).collect(),
                position: (0..2000).map(|i| position(at(i))).collect(),
                force: vec![0.0; 2000],
                velocity: Some(velocity),
                ..Recording::default()
            }
        };
        for (from, zeros) in [(0.1, 1), (0.3, 1), (0.8, 2)] {
            let recording = recording(from, zeros);
            let mended = without_outliers(&recording).velocity.unwrap();
            println!("{zeros} from {from} s: {:?}, then {}", &mended[..zeros], mended[zeros]);
            assert!(mended[..zeros].iter().all(|v| *v == mended[zeros]));
            let mut faults = Vec::new();
            far_from_neighbours(&recording, &mut faults);
            assert!(faults.len() == 1 && faults[0].why.contains("velocity"), "{faults:?}");
        }
        for zeros in [0, 1, 2] {
            let from_rest = recording(0.0, zeros);
            assert_eq!(without_outliers(&from_rest), from_rest, "{zeros}");
        }
    }
}
