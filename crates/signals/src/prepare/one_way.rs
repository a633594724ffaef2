//! Whether a body only ever advances.

use super::channels::Channels;
use crate::noise_std;

/// Parts of a stretch that must each advance, and by how many times the noise of a position.
const PARTS: usize = 32;
const ADVANCES: f64 = 5.0;

/// The direction in which the body advances in every part of the recordings.
#[must_use]
pub fn one_way(stretches: &[Channels]) -> Option<f64> {
    let part = stretches.iter().map(|s| s.position.len()).sum::<usize>().div_ceil(PARTS).max(4);
    let mut ways = stretches.iter().flat_map(|s| {
        let least = ADVANCES * noise_std(&s.position);
        // shorter parts tell too little to be asked
        s.position.chunks(part).filter(move |c| 2 * c.len() > part).map(move |c| {
            let by = c[c.len() - 1] - c[0];
            let range = c.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |r, x| (r.0.min(*x), r.1.max(*x)));
            // a part that comes back on the way does not only advance
            if by.abs() > least && range.1 - range.0 < by.abs() + least { by.signum() } else { 0.0 }
        })
    });
    let first = ways.next().filter(|w| *w != 0.0)?;
    ways.all(|w| w == first).then_some(first)
}
