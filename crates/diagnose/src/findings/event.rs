//! What happened once: a part of the recording with far more error than the others. No other part tells anything of it, so only its
//! time is known.

use crate::findings::locate::row_times;
use crate::search::hypothesis::Hypothesis;
use crate::search::judgement::Search;
use signals::quantile;
use std::ops::RangeInclusive;

/// Error of the worst block over the noise floor, and over the error of half of the blocks.
const ONCE: f64 = 5.0;
/// The same of a neighbour that belongs to it.
const NEAR: f64 = 3.0;

/// A part of the recording in which something happened once.
pub struct Event {
    /// Root mean square of the error of its worst block, in the unit of force.
    pub rms: f64,
    /// From when to when, s.
    pub between: (f64, f64),
    /// Its share of the squared error.
    pub share: f64,
}

/// The part of the recording in which `found` leaves far more than elsewhere, if there is one.
pub fn event(search: &Search, found: &Hypothesis) -> Option<Event> {
    let (design, blocks) = (search.design, &search.design.blocks);
    let squared: Vec<f64> =
        (0..blocks.len()).map(|k| blocks.rows(k).map(|r| found.fit.residual[r].powi(2)).sum()).collect();
    let errors: Vec<f64> =
        squared.iter().enumerate().map(|(k, s)| (s / blocks.rows(k).len().max(1) as f64).sqrt()).collect();
    let part = worst_part(&errors, design.rms(search.floor))?;
    let times = row_times(design);
    let all: f64 = squared.iter().sum();
    Some(Event {
        rms: errors[part.clone()].iter().copied().fold(0.0, f64::max),
        between: (times[blocks.rows(*part.start()).start], times[blocks.rows(*part.end()).end - 1]),
        share: squared[part].iter().sum::<f64>() / all,
    })
}

/// Neighbouring blocks around the one with the largest error, if that is far above the floor and above half of the others, and all
/// others are small.
fn worst_part(errors: &[f64], floor: f64) -> Option<RangeInclusive<usize>> {
    let usual = quantile(errors, 0.5).max(floor);
    let worst = (0..errors.len()).max_by(|a, b| errors[*a].total_cmp(&errors[*b]))?;
    if errors[worst] <= ONCE * usual {
        return None;
    }
    let large = |k: &usize| errors[*k] > NEAR * usual;
    let first = (0..=worst).rev().take_while(large).last()?;
    let last = (worst..errors.len()).take_while(large).last()?;
    let elsewhere = (0..errors.len()).filter(|k| !(first..=last).contains(k)).any(|k| large(&k));
    (!elsewhere).then_some(first..=last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cable_that_caught_for_a_moment_was_no_mismatch() {
        let mut errors = vec![0.02; 48];
        errors[20..23].copy_from_slice(&[0.08, 0.3, 0.09]);
        assert_eq!(worst_part(&errors, 0.02), Some(20..=22));
        // five times that of the others, and no more than the noise
        assert_eq!(worst_part(&errors, 0.1), None);
        // as much in most parts of the recording: it did not happen once
        errors[..30].fill(0.3);
        assert_eq!(worst_part(&errors, 0.02), None);
        assert_eq!(worst_part(&[], 0.02), None);
    }

    #[test]
    fn the_fast_end_of_a_chirp_that_came_twice_was_said_to_have_happened_once() {
        let mut errors = vec![0.02; 48];
        errors[20..24].copy_from_slice(&[0.08, 0.2, 0.3, 0.2]);
        errors[44..48].copy_from_slice(&[0.07, 0.2, 0.28, 0.2]);
        assert_eq!(worst_part(&errors, 0.02), None);
    }
}
