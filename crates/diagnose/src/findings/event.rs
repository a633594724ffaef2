//! What happened once, or a few times: parts of the recording with far more error than the others. No other part tells enough of
//! it, so only the times are known.

use crate::findings::locate::row_times;
use crate::search::hypothesis::Hypothesis;
use crate::search::judgement::Search;
use signals::quantile;
use std::ops::RangeInclusive;

/// Error of the worst block over the noise floor, and over the error of half of the blocks.
const RARE: f64 = 5.0;
/// The same of the other blocks that belong to it.
const NEAR: f64 = 3.0;
/// Most parts in which something that is rare happened.
const FEW: usize = 3;
/// Largest share of the blocks that they are together.
const SHORT: f64 = 0.25;

/// Parts of the recording in which something happened that is rare.
pub struct Event {
    /// Root mean square of the error of the worst block, in the unit of force.
    pub rms: f64,
    pub parts: Vec<Part>,
}

/// One of them.
pub struct Part {
    /// From when to when, s.
    pub between: (f64, f64),
    /// Its share of the squared error.
    pub share: f64,
}

/// The parts of the recording in which `found` leaves far more than elsewhere, if they are few.
pub fn event(search: &Search, found: &Hypothesis) -> Option<Event> {
    let (design, blocks) = (search.design, &search.design.blocks);
    let squared: Vec<f64> =
        (0..blocks.len()).map(|k| blocks.rows(k).map(|r| found.fit.residual[r].powi(2)).sum()).collect();
    let errors: Vec<f64> =
        squared.iter().enumerate().map(|(k, s)| (s / blocks.rows(k).len().max(1) as f64).sqrt()).collect();
    let parts = worst_parts(&errors, design.rms(search.floor))?;
    let times = row_times(design);
    let all: f64 = squared.iter().sum();
    let part = |part: RangeInclusive<usize>| Part {
        between: (times[blocks.rows(*part.start()).start], times[blocks.rows(*part.end()).end - 1]),
        share: squared[part].iter().sum::<f64>() / all,
    };
    let rms = errors.iter().copied().fold(0.0, f64::max);
    Some(Event { rms, parts: parts.into_iter().map(part).collect() })
}

/// Neighbouring blocks with a large error, if the largest is far above the floor and above half of the others, and they are few.
fn worst_parts(errors: &[f64], floor: f64) -> Option<Vec<RangeInclusive<usize>>> {
    let usual = quantile(errors, 0.5).max(floor);
    if errors.iter().copied().fold(0.0, f64::max) <= RARE * usual {
        return None;
    }
    let large: Vec<usize> = (0..errors.len()).filter(|k| errors[*k] > NEAR * usual).collect();
    let parts: Vec<_> = large.chunk_by(|a, b| a + 1 == *b).map(|p| p[0]..=p[p.len() - 1]).collect();
    let rare = parts.len() <= FEW && large.len() as f64 <= SHORT * errors.len() as f64;
    rare.then_some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cable_that_caught_for_a_moment_was_no_mismatch() {
        let mut errors = vec![0.02; 48];
        errors[20..23].copy_from_slice(&[0.08, 0.3, 0.09]);
        assert_eq!(worst_parts(&errors, 0.02), Some(vec![20..=22]));
        // five times that of the others, and no more than the noise
        assert_eq!(worst_parts(&errors, 0.1), None);
        // as much in most parts of the recording: it is not rare
        errors[..30].fill(0.3);
        assert_eq!(worst_parts(&errors, 0.02), None);
        assert_eq!(worst_parts(&[], 0.02), None);
    }

    #[test]
    fn the_fast_end_of_a_chirp_that_came_twice_is_two_parts() {
        let mut errors = vec![0.02; 48];
        errors[20..24].copy_from_slice(&[0.08, 0.2, 0.3, 0.2]);
        errors[44..48].copy_from_slice(&[0.07, 0.2, 0.28, 0.2]);
        assert_eq!(worst_parts(&errors, 0.02), Some(vec![20..=23, 44..=47]));
        for k in [5, 30] {
            errors[k] = 0.2;
        }
        assert_eq!(worst_parts(&errors, 0.02), None);
    }

    #[test]
    fn a_stop_that_was_hit_twice_was_no_mismatch() {
        let mut errors = vec![0.02; 48];
        (errors[9], errors[31]) = (0.4, 0.3);
        assert_eq!(worst_parts(&errors, 0.02), Some(vec![9..=9, 31..=31]));
    }
}
