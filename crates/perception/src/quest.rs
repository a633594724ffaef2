//! QUEST+ [watson-2017]: presents the difference with the most informative expected answer.
//!
//! The posterior lives on a grid over JND, slope and lapse rate. For every possible next difference its entropy is computed for
//! both answers; the difference with the smallest expected entropy is presented.

use crate::psychometric::Psychometric;

/// Grid of JNDs, slopes, lapse rates and differences.
const JNDS: usize = 61;
const SLOPES: [f64; 6] = [0.7, 1.0, 1.4, 2.0, 3.0, 4.5];
/// Weights of the slopes: log-normal around 1.6. A signal in Gaussian noise has slopes of 1.2 to 1.5 as a Weibull function;
/// measured slopes of touch are around 2.
const SLOPE_WEIGHTS: [f64; 6] = [0.09, 0.20, 0.27, 0.24, 0.13, 0.07];
const LAPSES: [f64; 4] = [0.0, 0.02, 0.05, 0.1];
/// Weights of the lapse rates: few answers lapse.
const LAPSE_WEIGHTS: [f64; 4] = [0.35, 0.35, 0.2, 0.1];
const DIFFERENCES: usize = 41;
/// Factor by which a JND may lie beyond the presented differences.
const MARGIN: f64 = 4.0;

/// Estimate of the JND.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief {
    /// Median of the posterior, N.
    pub jnd: f64,
    /// 95 % credible interval, N.
    pub ci95: (f64, f64),
    /// Whether the interval lies within the range of differences. If not, they do not reach the JND yet.
    pub reached: bool,
}

/// The QUEST+ procedure.
#[derive(Debug, Clone)]
pub struct QuestPlus {
    range: (f64, f64),
    differences: Vec<f64>,
    jnds: Vec<f64>,
    /// Likelihoods of the correct and the wrong answer, by difference and then by hypothesis.
    chances: Vec<Vec<[Chance; 2]>>,
    /// Posterior by hypothesis, JND slowest.
    posterior: Vec<f64>,
}

/// A probability and its logarithm, which would otherwise be computed a million times per session.
#[derive(Debug, Clone, Copy)]
struct Chance {
    p: f64,
    ln: f64,
}

impl Chance {
    fn new(p: f64) -> Self {
        Self { p, ln: p.ln() }
    }
}

/// `n` numbers from `low` to `high` with a constant ratio.
fn geometric(low: f64, high: f64, n: usize) -> Vec<f64> {
    let step = (high / low).ln() / (n - 1) as f64;
    (0..n).map(|k| low * (step * k as f64).exp()).collect()
}

impl QuestPlus {
    /// A procedure that presents differences in `range`, N, with a prior around that range.
    #[must_use]
    pub fn new(range: (f64, f64)) -> Self {
        let differences = geometric(range.0, range.1, DIFFERENCES);
        let jnds = geometric(range.0 / MARGIN, range.1 * MARGIN, JNDS);
        let mut hypotheses = Vec::new();
        let mut posterior = Vec::new();
        for &jnd in &jnds {
            for (&slope, &by_slope) in SLOPES.iter().zip(&SLOPE_WEIGHTS) {
                for (&lapse, &by_lapse) in LAPSES.iter().zip(&LAPSE_WEIGHTS) {
                    hypotheses.push(Psychometric { jnd, slope, lapse });
                    posterior.push(by_slope * by_lapse);
                }
            }
        }
        normalise(&mut posterior);
        let chances = |x: f64| {
            let both = |h: &Psychometric| {
                let p = h.p(x);
                [Chance::new(p), Chance::new(1.0 - p)]
            };
            hypotheses.iter().map(both).collect()
        };
        let chances = differences.iter().map(|&x| chances(x)).collect();
        Self { range, differences, jnds, chances, posterior }
    }

    /// The difference to present next, N.
    #[must_use]
    pub fn next(&self) -> f64 {
        let logarithms: Vec<f64> = self.posterior.iter().map(|w| w.ln()).collect();
        let expected = |chances: &[[Chance; 2]]| {
            // Σ over both answers of p(answer)·entropy(posterior | answer), without normalising each of them:
            // with w = posterior·likelihood and W = Σw, W·H = W·ln W − Σ w·ln w
            let (mut sums, mut logs) = ([0.0; 2], [0.0; 2]);
            for ((both, &weight), &ln) in chances.iter().zip(&self.posterior).zip(&logarithms) {
                for (k, chance) in both.iter().enumerate() {
                    let w = weight * chance.p;
                    if w > 0.0 {
                        sums[k] += w;
                        logs[k] += w * (ln + chance.ln);
                    }
                }
            }
            (0..2).filter(|&k| sums[k] > 0.0).map(|k| sums[k] * sums[k].ln() - logs[k]).sum::<f64>()
        };
        let least = self
            .chances
            .iter()
            .zip(&self.differences)
            .map(|(chances, &x)| (expected(chances), x))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        least.map_or(self.range.1, |(_, x)| x)
    }

    /// Updates the posterior with an answer to the difference `x`, N.
    pub fn answer(&mut self, x: f64, correct: bool) {
        let mut k = 0;
        for &jnd in &self.jnds {
            for &slope in &SLOPES {
                for &lapse in &LAPSES {
                    let p = Psychometric { jnd, slope, lapse }.p(x);
                    self.posterior[k] *= if correct { p } else { 1.0 - p };
                    k += 1;
                }
            }
        }
        normalise(&mut self.posterior);
    }

    /// Present estimate.
    #[must_use]
    pub fn belief(&self) -> Belief {
        let marginal: Vec<f64> =
            self.posterior.chunks(SLOPES.len() * LAPSES.len()).map(|chunk| chunk.iter().sum()).collect();
        let quantile = |q: f64| {
            let mut sum = 0.0;
            for (k, &weight) in marginal.iter().enumerate() {
                if sum + weight >= q {
                    // within a cell of the grid the logarithm is uniform
                    let share = ((q - sum) / weight.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0) - 0.5;
                    let step = (self.jnds[1] / self.jnds[0]).ln();
                    return self.jnds[k] * (share * step).exp();
                }
                sum += weight;
            }
            self.range.1 * MARGIN
        };
        let ci95 = (quantile(0.025), quantile(0.975));
        let reached = ci95.0 >= self.range.0 && ci95.1 <= self.range.1;
        Belief { jnd: quantile(0.5), ci95, reached }
    }
}

fn normalise(weights: &mut [f64]) {
    let sum: f64 = weights.iter().sum();
    if sum > 0.0 {
        weights.iter_mut().for_each(|w| *w /= sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn forty_answers_find_the_jnd() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let (mut errors, mut inside) = (Vec::new(), 0);
        let n = 60;
        for k in 0..n {
            let jnd = 0.08 * (1.0 + f64::from(k) * 0.6);
            let mut quest = QuestPlus::new((0.02, 4.0));
            for _ in 0..40 {
                let x = quest.next();
                // the observer is not a Weibull function: Gaussian noise, ¾ = Φ(0.6745)
                let p = normal_cdf(0.6745 * x / jnd);
                quest.answer(x, rng.random_bool(p.clamp(0.0, 0.98)));
            }
            let belief = quest.belief();
            errors.push((belief.jnd / jnd).ln());
            inside += usize::from(belief.ci95.0 <= jnd && jnd <= belief.ci95.1);
        }
        let mean = errors.iter().sum::<f64>() / f64::from(n);
        let spread = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / f64::from(n)).sqrt();
        println!(
            "QUEST+, 40 answers, {n} observers from 0.08 to 2.9 N: bias {:+.1} %, spread {:.0} %, {inside} in the 95 % interval",
            100.0 * mean.exp_m1(),
            100.0 * spread
        );
        assert!(mean.abs() < 0.12 && spread < 0.45 && inside >= 52);
    }

    fn normal_cdf(z: f64) -> f64 {
        // Φ by summing the density, independent of the crate
        let n = 4000;
        let h = (z + 8.0) / f64::from(n);
        (0..n).map(|k| (-0.5 * (-8.0 + (f64::from(k) + 0.5) * h).powi(2)).exp() * h).sum::<f64>()
            / (2.0 * std::f64::consts::PI).sqrt()
    }
}
