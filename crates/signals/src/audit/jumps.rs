//! Jumps of the position under an even clock that no motion explains: samples that are missing although the times were
//! numbered anew, an encoder that lost counts, a log that held a value and then caught up.
//!
//! A parabola through the samples before and one through those after meet in the middle, whatever accelerates the body.
//! They miss each other by less than 1.9 standard deviations of a sample's noise for each that noise has, by up to half of
//! a sudden change of speed times the period, and by up to 0.7 of a sudden change of acceleration times its square. What is
//! beyond all of that is no motion.

use super::fault::{FaultKind, RecordingFault};
use crate::Recording;
use crate::noise::noise_variance;
use crate::stretches::Stretch;

/// Samples on either side.
const SIDE: usize = 6;
/// Standard deviations that chance does not reach in tens of thousands of samples.
const SURE: f64 = 8.0;
/// Standard deviation of the miss for a standard deviation of a sample.
const MISS: f64 = 1.83;
/// Standard deviations of either parabola's own misfit: a spike or a blow within its samples bends it.
const BENT: f64 = 4.0;
/// Samples' worth of motion from which a jump along the motion can be lost samples.
const A_SAMPLE: f64 = 0.7;
/// Steps of the clock that count as even, as a share of the period.
const EVEN: f64 = 0.2;
/// Jumps that are reported one by one.
const ONE_BY_ONE: usize = 8;
/// Fewest samples to a jump: with more of them it is a channel that is updated less often than it is recorded.
const RARE: usize = 100;

/// A jump of the position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// First sample after it.
    pub index: usize,
    /// Its size, m or rad.
    pub size: f64,
    /// Samples lost that would explain it; None where no number of them does.
    pub lost: Option<f64>,
}

/// A parabola through [`SIDE`] samples at 0.5, 1.5, … from the middle: value and slope there, curvature, misfit.
struct Parabola {
    value: f64,
    slope: f64,
    curvature: f64,
    misfit: f64,
}

impl Parabola {
    fn through(samples: [f64; SIDE]) -> Self {
        // polynomials orthogonal on six even points, centred at 3 from the middle
        const LINE: [f64; SIDE] = [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5];
        const BOW: [f64; SIDE] = [5.0, -1.0, -4.0, -4.0, -1.0, 5.0];
        let along = |p: &[f64; SIDE]| -> f64 {
            let (sum, square) =
                p.iter().zip(samples).fold((0.0, 0.0), |(sum, square), (p, x)| (sum + p * x, square + p * p));
            sum / square
        };
        let (mean, line, bow) = (samples.iter().sum::<f64>() / SIDE as f64, along(&LINE), along(&BOW));
        let square: f64 =
            (0..SIDE).map(|i| (samples[i] - mean - line * LINE[i] - bow * BOW[i]).powi(2)).sum();
        // the bow is 1.5·u² − 4.375 of u, the distance from the centre
        Self {
            value: mean - 3.0 * line + bow * (1.5 * 9.0 - 4.375),
            slope: line - 9.0 * bow,
            curvature: 3.0 * bow,
            misfit: (square / (SIDE - 3) as f64).sqrt(),
        }
    }
}

/// Jumps of the position in the stretches of a recording.
#[must_use]
pub fn jumps(recording: &Recording, stretches: &[Stretch]) -> Vec<Jump> {
    let mut out = Vec::new();
    for stretch in stretches {
        let Some(position) = recording.position.get(stretch.range.clone()) else { continue };
        let time = &recording.time[stretch.range.clone()];
        let noise = noise_variance(position).sqrt();
        let found = of(time, position, stretch.dt, noise);
        if found.len() * RARE <= position.len() {
            out.extend(found.into_iter().map(|j| Jump { index: j.index + stretch.range.start, ..j }));
        }
    }
    out
}

fn of(time: &[f64], position: &[f64], dt: f64, noise: f64) -> Vec<Jump> {
    let is_even = |i: usize| ((time[i] - time[i - 1]) / dt - 1.0).abs() < EVEN;
    let mut found: Vec<(Jump, f64)> = Vec::new();
    for i in SIDE..position.len().saturating_sub(SIDE - 1) {
        let before = Parabola::through(std::array::from_fn(|k| position[i - 1 - k]));
        let after = Parabola::through(std::array::from_fn(|k| position[i + k]));
        let size = after.value - before.value;
        let (v_before, v_after) = (-before.slope, after.slope);
        let explained = SURE * MISS * noise
            + (v_after - v_before).abs()
            + 1.5 * (after.curvature - before.curvature).abs()
            + BENT * before.misfit.max(after.misfit)
            + A_SAMPLE * v_before.abs().min(v_after.abs());
        if !(size.abs() > explained) || !(i + 1 - SIDE..i + SIDE).all(is_even) {
            continue;
        }
        let speed = 0.5 * (v_before + v_after);
        let along = v_before * v_after > 0.0 && speed * size > 0.0;
        let jump = Jump { index: i, size, lost: along.then(|| (size / speed).round().max(1.0)) };
        let excess = size.abs() / explained;
        match found.last_mut() {
            // the same jump again, seen from the next sample
            Some((last, best)) if i < last.index + SIDE => {
                if excess > *best {
                    (*last, *best) = (jump, excess);
                }
            }
            _ => found.push((jump, excess)),
        }
    }
    found.into_iter().map(|(jump, _)| jump).collect()
}

/// One fault for each jump, and one for all that are beyond the first.
pub(super) fn report(recording: &Recording, stretches: &[Stretch], out: &mut Vec<RecordingFault>) {
    let unit = friction::Dimension::LENGTH.unit(recording.geometry);
    let found = jumps(recording, stretches);
    for jump in found.iter().take(ONE_BY_ONE) {
        let (at, before) = (recording.time[jump.index], recording.time[jump.index - 1]);
        let size = jump.size;
        let (kind, because) = match jump.lost {
            Some(lost) => (
                FaultKind::LostSamples,
                format!("as in {:.0} samples: about {} missing", lost + 1.0, super::clock::samples(lost)),
            ),
            None => (FaultKind::PositionJump, "and no motion explains it".into()),
        };
        let why = format!(
            "the position jumps by {size:.3e} {unit} after {before:.6} s although the clock does not, {because}"
        );
        out.push(RecordingFault::new(kind, Some(at), why));
    }
    if let Some(next) = found.get(ONE_BY_ONE) {
        let why = format!("{} further jumps of the position", found.len() - ONE_BY_ONE);
        out.push(RecordingFault::new(FaultKind::PositionJump, Some(recording.time[next.index]), why));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_found_as_it_is() {
        let p = Parabola::through(std::array::from_fn(|k| {
            let u = k as f64 + 0.5;
            2.0 - 3.0 * u + 0.25 * u * u
        }));
        assert!((p.value - 2.0).abs() < 1e-12 && (p.slope + 3.0).abs() < 1e-12);
        assert!((p.curvature - 0.5).abs() < 1e-12 && p.misfit < 1e-12);
    }

    #[test]
    fn blows_and_starts_are_motion() {
        let time: Vec<f64> = (0..400).map(|i| f64::from(i) * 1e-3).collect();
        for at in [0.2, 0.2002, 0.2005, 0.2009] {
            for body in [&(|t: f64| t) as &dyn Fn(f64) -> f64, &|t| -0.8 * t, &|t| 500.0 * t * t, &|t| {
                -t - 2000.0 * t * t
            }] {
                let place = |t: f64| if t < at { t } else { at + body(t - at) };
                let position: Vec<f64> = time.iter().map(|t| place(*t)).collect();
                assert_eq!(of(&time, &position, 1e-3, 1e-9), [], "at {at}");
            }
        }
    }
}
