//! Tests that stay honest under autocorrelated noise: signs of whole blocks are flipped, the maximum over
//! everything that was looked at is kept, and held-out gains are bootstrapped by blocks.

use crate::regression::linear::Blocks;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use signals::{dot, random_signs};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Scores of one direction in every block.
pub type Scores = Vec<f64>;

/// Sum of `column · residual` in every block.
pub fn block_scores(column: &[f64], residual: &[f64], blocks: &Blocks) -> Scores {
    (0..blocks.len()).map(|k| dot(&column[blocks.rows(k)], &residual[blocks.rows(k)])).collect()
}

/// The outcome of a family of tests.
#[derive(Debug, Clone)]
pub struct Family {
    /// Family-wise p value of each member.
    pub p: Vec<f64>,
    /// 95 % quantile of the maximum when nothing is there.
    pub critical_95: f64,
}

/// Max-statistic test of many directions at once.
///
/// `observed[j]` are the block scores of direction j against the residual of the null model, `noise[j]` the
/// same against the residual taken as noise (the richest model that fits, or the null model's own), `scale[j]`
/// what the standard deviation of the sum would be if rows were independent. The noise scores are flipped
/// block by block, which keeps their autocorrelation and the dependence between directions.
pub fn family(observed: &[Scores], noise: &[Scores], scale: &[f64], flips: usize, seed: u64) -> Family {
    let deviation: Vec<f64> = noise
        .iter()
        .zip(scale)
        .map(|(s, white)| {
            // Half the blockwise, half the independent estimate: a direction that lives in two blocks would
            // otherwise be divided by a number it happened to fit to zero.
            (0.5 * s.iter().map(|x| x * x).sum::<f64>() + 0.5 * white * white).sqrt()
        })
        .collect();
    let t: Vec<f64> = observed
        .iter()
        .zip(&deviation)
        .map(|(s, d)| if *d > 0.0 { (s.iter().sum::<f64>() / d).abs() } else { 0.0 })
        .collect();
    let blocks = observed.first().map_or(0, Vec::len);
    let largest = |signs: &Vec<f64>| {
        let of = |(s, d): (&Scores, &f64)| if *d > 0.0 { (dot(s, signs) / d).abs() } else { 0.0 };
        noise.iter().zip(&deviation).map(of).fold(0.0, f64::max)
    };
    let mut maxima: Vec<f64> = random_signs(flips, blocks, seed).par_iter().map(largest).collect();
    maxima.sort_by(f64::total_cmp);
    let p = t
        .iter()
        .map(|t| {
            let above = flips - maxima.partition_point(|m| m < t);
            (above + 1) as f64 / (flips + 1) as f64
        })
        .collect();
    let at = |q: f64| {
        maxima
            .get(((q * flips as f64) as usize).min(flips.saturating_sub(1)))
            .copied()
            .unwrap_or(f64::INFINITY)
    };
    Family { p, critical_95: at(0.95) }
}

/// 95 % interval of the drop in held-out root mean square from `before` to `after`, squared errors by block: a circular
/// bootstrap of runs of blocks as long as the gain remembers itself, opened by Student's factor for how few such runs
/// there are.
///
/// `recordings` says which recording each block is of; empty for one. Runs are drawn within a recording: that an effect
/// shows more in one than in another is how they were made, not chance.
pub fn gain_interval(
    before: &[f64],
    after: &[f64],
    weight: &[f64],
    recordings: &[usize],
    draws: usize,
    seed: u64,
) -> [f64; 2] {
    let k = before.len();
    if k == 0 {
        return [0.0, 0.0];
    }
    let gain = |b: f64, a: f64, w: f64| if w > 0.0 { (b / w).sqrt() - (a / w).sqrt() } else { 0.0 };
    let parts = parts(recordings, k);
    let mut differences: Vec<f64> = before.iter().zip(after).map(|(b, a)| b - a).collect();
    for part in &parts {
        let part = &mut differences[part.clone()];
        let mean = part.iter().sum::<f64>() / part.len() as f64;
        part.iter_mut().for_each(|d| *d -= mean);
    }
    let run = run_length(&differences);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut gains: Vec<f64> = (0..draws)
        .map(|_| {
            let (mut b, mut a, mut w) = (0.0, 0.0, 0.0);
            for part in &parts {
                let (from, count) = (part.start, part.len());
                let mut at = 0;
                for drawn in 0..count {
                    at = if drawn % run == 0 { random.random_range(0..count) } else { (at + 1) % count };
                    b += before[from + at];
                    a += after[from + at];
                    w += weight[from + at];
                }
            }
            gain(b, a, w)
        })
        .collect();
    gains.sort_by(f64::total_cmp);
    let (low, high) = (gains[draws * 25 / 1000], gains[(draws * 975 / 1000).min(draws - 1)]);
    let middle = gain(before.iter().sum(), after.iter().sum(), weight.iter().sum());
    let runs = (k as f64 / run as f64).max(3.0);
    let open = StudentsT::new(0.0, 1.0, runs - 1.0).map_or(1.0, |t| t.inverse_cdf(0.975) / 1.959_964);
    [middle + open * (low - middle), middle + open * (high - middle)]
}

/// Stretches of blocks of the same recording.
fn parts(recordings: &[usize], k: usize) -> Vec<std::ops::Range<usize>> {
    if recordings.len() != k {
        return std::iter::once(0..k).collect();
    }
    let mut out = Vec::new();
    let mut from = 0;
    for to in 1..=k {
        if recordings.get(to) != Some(&recordings[from]) {
            out.push(from..to);
            from = to;
        }
    }
    out
}

/// Blocks a run should have: Politis and White (2004) for the circular bootstrap, corrected by Patton (2009); a quarter
/// of them at most, and the cube root of their number at least: a memory too weak to be seen in so few is still one.
fn run_length(series: &[f64]) -> usize {
    let n = series.len();
    let count = n as f64;
    let least = count.cbrt().round() as usize;
    let mean = series.iter().sum::<f64>() / count;
    let centred: Vec<f64> = series.iter().map(|x| x - mean).collect();
    let lagged: Vec<f64> = (0..n).map(|lag| dot(&centred[..n - lag], &centred[lag..]) / count).collect();
    if n < 8 || !(lagged[0] > 0.0) {
        return 1;
    }
    let quiet = 2.0 * (count.log10() / count).sqrt();
    let look = 5.min(n / 4);
    let last = (n / 4).max(1);
    let small = |lag: usize| lagged.get(lag).is_none_or(|r| (r / lagged[0]).abs() < quiet);
    let memory = (0..last).find(|m| (m + 1..=m + look).all(small)).unwrap_or(last);
    if memory == 0 {
        return least;
    }
    let (mut bend, mut spectrum) = (0.0, lagged[0]);
    for (lag, r) in lagged.iter().enumerate().skip(1).take(2 * memory) {
        let taper = (2.0 * (1.0 - lag as f64 / (2 * memory) as f64)).min(1.0);
        bend += 2.0 * taper * lag as f64 * r;
        spectrum += 2.0 * taper * r;
    }
    let best = (1.5 * bend * bend / (spectrum * spectrum).max(1e-300) * count).cbrt();
    (best.round() as usize).clamp(least, (n / 4).max(least))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn false_alarms_stay_near_nominal_under_autocorrelation() {
        let blocks = Blocks {
            edges: (0..=30).map(|k| k * 40).collect(),
            starts: vec![false; 30],
            ..Blocks::default()
        };
        let columns: Vec<Vec<f64>> =
            (1..30).map(|j| (0..1200).map(|i| (i as f64 * 0.02 * j as f64).sin()).collect()).collect();
        let mut alarms = 0;
        for seed in 0..200 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut state = 0.0;
            let noise: Vec<f64> = (0..1200)
                .map(|_| {
                    let w: f64 = StandardNormal.sample(&mut random);
                    state = 0.8 * state + w;
                    state
                })
                .collect();
            let scores: Vec<Scores> = columns.iter().map(|c| block_scores(c, &noise, &blocks)).collect();
            let scale = vec![0.0; scores.len()];
            let family = family(&scores, &scores, &scale, 199, seed);
            alarms += usize::from(family.p.iter().any(|p| *p <= 0.05));
        }
        println!("{alarms} alarms in 200 at a nominal 5 %");
        assert!((2..=22).contains(&alarms));
    }

    #[test]
    fn gain_intervals_cover_where_neighbouring_blocks_gain_alike() {
        let (k, trials) = (48, 300);
        let mut covered = 0;
        for seed in 0..trials {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut state = 0.0;
            let gains: Vec<f64> = (0..k)
                .map(|_| {
                    let w: f64 = StandardNormal.sample(&mut random);
                    state = 0.3 * state + 0.954 * w;
                    1.0 + 0.25 * state
                })
                .collect();
            let after = vec![1.0; k];
            let before: Vec<f64> = gains.iter().map(|g| 1.0 + g).collect();
            let [low, high] = gain_interval(&before, &after, &vec![1.0; k], &[], 400, seed);
            let truth = 2f64.sqrt() - 1.0;
            covered += usize::from(low <= truth && truth <= high);
        }
        println!("{covered} of {trials} intervals hold the gain at a nominal 95 %");
        assert!(covered * 100 >= trials as usize * 90, "{covered}");
    }

    #[test]
    fn an_effect_that_shows_in_one_of_two_recordings_is_no_less_sure() {
        let gains: Vec<f64> =
            (0..40).map(|i| if i < 20 { 0.01 } else { 1.0 } * (1.0 + 0.1 * f64::from(i % 3))).collect();
        let after = vec![1.0; 40];
        let before: Vec<f64> = gains.iter().map(|g| 1.0 + g).collect();
        let recordings: Vec<usize> = (0..40).map(|i| i / 20).collect();
        let interval = |r: &[usize]| gain_interval(&before, &after, &after, r, 1000, 1);
        println!("as one recording {:?}, as two {:?}", interval(&[]), interval(&recordings));
        assert!(interval(&[])[0] < 0.0 && interval(&recordings)[0] > 0.2);
    }
}
