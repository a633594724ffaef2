//! Fine lines: forces that repeat over a distance much shorter than the stroke (the pitch of a screw, the teeth of a
//! motor), found in the residual's spectrum over *position*.
//!
//! A catalogue of every wavelength would be as long as the stroke has waves. A scan is cheap: at every wavelength the
//! residual is correlated with a cosine and a sine of the position, block by block, and the largest of all is compared
//! with the largest that is left when the signs of whole blocks are flipped. Only what stands out there goes into the
//! catalogue, to be tested like everything else.

use crate::findings::locate::row_motion;
use crate::library::design_matrix::DesignMatrix;
use crate::library::scales::Scales;
use rayon::prelude::*;
use signals::random_signs;
use std::f64::consts::TAU;

/// Waves over the stroke between two lines that are scanned: at half a wave's distance none falls between.
const SPACING: f64 = 0.4;
/// Random signs drawn, and the level of the largest line among all.
const FLIPS: usize = 199;
const LEVEL: f64 = 0.01;
/// Most lines taken from a scan.
const MAX_LINES: usize = 3;
/// The residual itself, turned with the direction, and times the force.
const CARRIERS: usize = 3;
/// Most lines scanned.
const LINES: usize = 2000;

/// Rows looked at: of a longer recording every second, third, …
const ROWS: usize = 40_000;

/// Wavelengths finer than `coarsest` at which the residual repeats over position, strongest first: as a force that is
/// the same in both directions, one that turns with the direction, or one that grows with the force.
pub fn fine(design: &DesignMatrix, residual: &[f64], scales: &Scales, seed: u64) -> Vec<f64> {
    let span = scales.stroke.1 - scales.stroke.0;
    let (first, last) = (span / scales.coarse_wave(), span / scales.finest_wave());
    if !(span > 0.0 && last > first) {
        return Vec::new();
    }
    let count = (((last - first) / SPACING) as usize).min(LINES);
    let waves: Vec<f64> = (0..count).map(|i| (first + SPACING * i as f64) / span).collect();
    let (x, v) = row_motion(design);
    let step = x.len().div_ceil(ROWS).max(1);
    let rows: Vec<Vec<(f64, [f64; CARRIERS])>> = (0..design.blocks.len())
        .map(|b| {
            let used = design.blocks.rows(b).step_by(step).filter(|&r| x[r].is_finite());
            used.map(|r| (x[r], [residual[r], residual[r] * v[r].signum(), residual[r] * design.y[r]]))
                .collect()
        })
        .collect();
    let score = |k: &f64| -> Vec<[[f64; 2]; CARRIERS]> {
        let of = |block: &Vec<(f64, [f64; CARRIERS])>| {
            let mut sum = [[0.0; 2]; CARRIERS];
            for (x, e) in block {
                let (sine, cosine) = (TAU * k * x).sin_cos();
                for (s, e) in sum.iter_mut().zip(e) {
                    s[0] += e * cosine;
                    s[1] += e * sine;
                }
            }
            sum
        };
        rows.iter().map(of).collect()
    };
    let scores: Vec<Vec<[[f64; 2]; CARRIERS]>> = waves.par_iter().map(score).collect();
    let mut found: Vec<(f64, f64)> =
        (0..CARRIERS).flat_map(|c| peaks(&scores, c, design.blocks.len(), &waves, seed)).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut out: Vec<f64> = Vec::new();
    for (_, per_length) in found {
        if out.len() < MAX_LINES && out.iter().all(|o| (1.0 / o - per_length).abs() * span > 1.0) {
            out.push(1.0 / per_length);
        }
    }
    out
}

/// Lines of one carrier, as waves per length, that stand out of what flipped signs leave; with how far.
fn peaks(
    scores: &[Vec<[[f64; 2]; CARRIERS]>],
    carrier: usize,
    blocks: usize,
    waves: &[f64],
    seed: u64,
) -> Vec<(f64, f64)> {
    // relative to what the blocks would give without agreeing with each other
    let power = |line: &[[[f64; 2]; CARRIERS]], signs: &[f64]| -> f64 {
        let (mut sum, mut alone) = ([0.0; 2], 0.0);
        for (of, sign) in line.iter().zip(signs) {
            let [c, s] = of[carrier];
            sum = [sum[0] + sign * c, sum[1] + sign * s];
            alone += c * c + s * s;
        }
        if alone > 0.0 { (sum[0] * sum[0] + sum[1] * sum[1]) / alone } else { 0.0 }
    };
    let observed: Vec<f64> = scores.iter().map(|line| power(line, &vec![1.0; blocks])).collect();
    let signs = random_signs(FLIPS, blocks, seed ^ 0x11e5);
    let largest = |signs: &Vec<f64>| scores.iter().map(|line| power(line, signs)).fold(0.0, f64::max);
    let mut maxima: Vec<f64> = signs.par_iter().map(largest).collect();
    maxima.sort_by(f64::total_cmp);
    let critical = maxima[((FLIPS as f64 * (1.0 - LEVEL)) as usize).min(FLIPS - 1)];
    let at = |i: usize| observed.get(i).copied().unwrap_or(0.0);
    (0..waves.len())
        .filter(|&i| at(i) > critical && at(i) >= at(i + 1) && (i == 0 || at(i) >= at(i - 1)))
        .map(|i| (at(i) / critical, waves[i]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preparation::track::Reversals;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use signals::Channels;

    /// A slide that goes up and down at two speeds, with noise and, if `line` > 0, a force that repeats over `pitch`.
    fn design(line: f64, pitch: f64, seed: u64) -> (DesignMatrix, Scales) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = || (0..4).map(|_| random.random::<f64>() - 0.5).sum::<f64>();
        let n = 16_000;
        let place = |t: f64| 0.05 * (1.1 * t).sin() + 0.03 * (2.9 * t).sin();
        let dt = 1e-3;
        let position: Vec<f64> = (0..n).map(|i| place(i as f64 * dt)).collect();
        let slope = |i: usize, h: f64| (place(i as f64 * dt + h) - place(i as f64 * dt - h)) / (2.0 * h);
        let force = (0..n)
            .map(|i| {
                let v = slope(i, 1e-5);
                2.0 * v.signum() + 3.0 * v + line * (TAU * position[i] / pitch + 0.4).cos() + 0.3 * draw()
            })
            .collect();
        let raw = Channels { position, force, dt, ..Channels::default() };
        let design = DesignMatrix::new(&[raw], 40.0, Reversals::default(), false).expect("a design");
        let scales = Scales::of(&design.tracks, 40.0);
        (design, scales)
    }

    #[test]
    fn a_pitch_too_fine_for_the_grid_is_found_and_noise_has_none() {
        let mut alarms = 0;
        for seed in 0..12 {
            let of = |(design, scales): (DesignMatrix, Scales)| {
                let columns: Vec<&[f64]> = design.baseline.iter().map(Vec::as_slice).collect();
                let fit =
                    crate::regression::linear::fit(&columns, &design.y, &design.blocks, 4).expect("a fit");
                fine(&design, &fit.residual, &scales, 1)
            };
            let found = of(design(0.1, 0.0025, seed));
            alarms += of(design(0.0, 1.0, 100 + seed)).len();
            println!("{seed}: lines at {found:?}");
            assert!(found.first().is_some_and(|l| (l / 0.0025 - 1.0).abs() < 0.01));
        }
        println!("{alarms} lines in 12 recordings without one");
        assert!(alarms <= 2);
    }
}
