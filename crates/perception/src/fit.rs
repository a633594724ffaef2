//! Fit of a psychometric function: the just noticeable difference with an interval, or the reason why there is none.
//!
//! Bayesian inference on a grid over JND, slope and lapse rate [schuett-2016]. Slope and lapse rate are marginalised, so the
//! interval includes their uncertainty. The prior of the JND is uniform in its logarithm, far beyond the presented levels.

use crate::psychometric::Psychometric;
use serde::{Deserialize, Serialize};

/// Answers to one difference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// Difference, N.
    pub difference_n: f64,
    /// Number of correct answers.
    pub correct: u32,
    /// Number of answers.
    pub answers: u32,
}

/// Threshold of a psychometric function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum Threshold {
    /// The levels enclose the JND.
    Estimated {
        /// Median of the posterior, N.
        jnd: f64,
        /// 95 % interval, N.
        ci95: (f64, f64),
    },
    /// The JND may lie above every level: it cannot be estimated from these levels.
    AboveLevels {
        /// Largest level, N.
        largest: f64,
        /// Lower bound of the JND with 95 % probability, N.
        at_least: f64,
    },
    /// The JND may lie below every level.
    BelowLevels {
        /// Smallest level, N.
        smallest: f64,
        /// Upper bound of the JND with 95 % probability, N.
        at_most: f64,
    },
    /// Too few answers: the JND may lie beyond the levels on either side.
    TooFew,
}

/// A fitted psychometric function.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// The JND, or the reason why there is none.
    pub threshold: Threshold,
    /// Medians of the posterior: the curve to draw. Its JND is a result only if [`Self::threshold`] is one.
    pub curve: Psychometric,
    /// Deviance of that curve from the observed shares.
    pub deviance: f64,
    /// The fitted answers.
    pub levels: Vec<Level>,
}

/// Largest probability of a JND beyond the levels on one side that still gives an estimate.
const MAX_OUTSIDE: f64 = 0.05;
/// Cells over JND, slope and lapse rate: a coarse grid, then a fine one where the coarse posterior has mass.
const COARSE: [usize; 3] = [61, 9, 4];
const FINE: [usize; 3] = [91, 13, 6];
/// Share of the posterior on each side that the fine grid may miss.
const MISSED: f64 = 1e-5;
/// Factor by which the grid extends beyond the levels.
const REACH: f64 = 20.0;

/// Answers by difference, smallest first.
#[must_use]
pub fn levels(answers: impl IntoIterator<Item = (f64, bool)>) -> Vec<Level> {
    let mut all: Vec<Level> = Vec::new();
    for (difference_n, right) in answers {
        let same = |level: &&mut Level| (level.difference_n - difference_n).abs() <= 1e-9;
        let place = match all.iter_mut().find(same) {
            Some(level) => level,
            None => {
                all.push(Level { difference_n, correct: 0, answers: 0 });
                let last = all.len() - 1;
                &mut all[last]
            }
        };
        place.answers += 1;
        place.correct += u32::from(right);
    }
    all.sort_by(|a, b| a.difference_n.total_cmp(&b.difference_n));
    all
}

impl Fit {
    /// Fits the answers. `None` without an answer to a difference above zero.
    #[must_use]
    pub fn new(levels: &[Level]) -> Option<Self> {
        let levels: Vec<Level> =
            levels.iter().copied().filter(|l| l.difference_n > 0.0 && l.answers > 0).collect();
        let smallest = levels.first()?.difference_n;
        let largest = levels.last()?.difference_n;
        let coarse = Posterior::new(&levels, (smallest / REACH, largest * REACH), COARSE);
        let fine = Posterior::new(&levels, coarse.found(), FINE);
        let Posterior { jnds, slopes, lapses, .. } = &fine;
        let [of_jnd, of_slope, of_lapse] = fine.marginals();
        let q = |p: f64| quantile(jnds, &of_jnd, p);
        let mass = |test: &dyn Fn(f64) -> bool| -> f64 {
            jnds.iter().zip(&of_jnd).filter(|(jnd, _)| test(**jnd)).map(|(_, p)| p).sum()
        };
        let above = mass(&|jnd| jnd > largest) > MAX_OUTSIDE;
        let below = mass(&|jnd| jnd < smallest) > MAX_OUTSIDE;
        let threshold = match (above, below) {
            (false, false) => Threshold::Estimated { jnd: q(0.5), ci95: (q(0.025), q(0.975)) },
            (true, false) => Threshold::AboveLevels { largest, at_least: q(0.05) },
            (false, true) => Threshold::BelowLevels { smallest, at_most: q(0.95) },
            (true, true) => Threshold::TooFew,
        };
        let lapse = lapses.iter().zip(&of_lapse).map(|(x, p)| x * p).sum();
        let curve = Psychometric { jnd: q(0.5), slope: quantile(slopes, &of_slope, 0.5), lapse };
        let own: f64 = levels.iter().map(|l| term(f64::from(l.correct) / f64::from(l.answers), l)).sum();
        let deviance = 2.0 * (own - likelihood(&curve, &levels));
        Some(Self { threshold, curve, deviance, levels })
    }
}

/// Posterior on a grid.
struct Posterior {
    jnds: Vec<f64>,
    slopes: Vec<f64>,
    lapses: Vec<f64>,
    /// Probabilities, JND slowest, lapse rate fastest.
    density: Vec<f64>,
}

impl Posterior {
    fn new(levels: &[Level], (low, high): (f64, f64), [jnds, slopes, lapses]: [usize; 3]) -> Self {
        let axis = |low: f64, high: f64, n: usize| -> Vec<f64> {
            (0..n).map(|k| low * (high / low).powf(k as f64 / (n - 1) as f64)).collect()
        };
        let jnds = axis(low, high, jnds);
        // slopes of human senses are known to lie within 0.6 and 8
        let slopes = axis(0.6, 8.0, slopes);
        let lapses: Vec<f64> = (0..lapses).map(|k| 0.12 * k as f64 / (lapses - 1) as f64).collect();
        let mut density = Vec::with_capacity(jnds.len() * slopes.len() * lapses.len());
        for &jnd in &jnds {
            for &slope in &slopes {
                for &lapse in &lapses {
                    density
                        .push(likelihood(&Psychometric { jnd, slope, lapse }, levels) + prior(slope, lapse));
                }
            }
        }
        let best = density.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        density.iter_mut().for_each(|log| *log = (*log - best).exp());
        Self { jnds, slopes, lapses, density }
    }

    fn marginals(&self) -> [Vec<f64>; 3] {
        let (slopes, lapses) = (self.slopes.len(), self.lapses.len());
        let mut sums = [vec![0.0; self.jnds.len()], vec![0.0; slopes], vec![0.0; lapses]];
        let all: f64 = self.density.iter().sum();
        for (at, p) in self.density.iter().enumerate() {
            sums[0][at / (slopes * lapses)] += p / all;
            sums[1][at / lapses % slopes] += p / all;
            sums[2][at % lapses] += p / all;
        }
        sums
    }

    /// Range of JNDs with nearly all of the posterior, plus a cell.
    fn found(&self) -> (f64, f64) {
        let [of_jnd, ..] = self.marginals();
        let step = self.jnds[1] / self.jnds[0];
        (quantile(&self.jnds, &of_jnd, MISSED) / step, quantile(&self.jnds, &of_jnd, 1.0 - MISSED) * step)
    }
}

/// Prior: slopes within a factor of 1.8 around 1.8, few lapses.
fn prior(slope: f64, lapse: f64) -> f64 {
    -0.5 * ((slope / 1.8).ln() / 1.8_f64.ln()).powi(2) - lapse / 0.03
}

fn likelihood(curve: &Psychometric, levels: &[Level]) -> f64 {
    levels.iter().map(|level| term(curve.p(level.difference_n), level)).sum()
}

fn term(p: f64, level: &Level) -> f64 {
    let log = |n: u32, p: f64| if n == 0 { 0.0 } else { f64::from(n) * p.max(1e-300).ln() };
    log(level.correct, p) + log(level.answers - level.correct, 1.0 - p)
}

/// Quantile on a grid of equal factors, with the mass of a cell spread over it.
fn quantile(grid: &[f64], mass: &[f64], q: f64) -> f64 {
    let step = (grid[1] / grid[0]).ln();
    let mut sum = 0.0;
    for (x, m) in grid.iter().zip(mass) {
        if sum + m >= q {
            return x * (step * ((q - sum) / m.max(f64::MIN_POSITIVE) - 0.5)).exp();
        }
        sum += m;
    }
    grid.last().copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observer::Observer;
    use crate::quest::QuestPlus;
    use crate::stimulus::Stimulus;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    struct Recovered {
        bias: f64,
        covered: f64,
        spread: f64,
        not: usize,
    }

    /// Estimates of 200 observers for each seed, with JNDs from 0.25 to 1.6 N. Their answers come from noise on the percept,
    /// not from a Weibull function. `ask` presents and answers.
    fn recover(
        what: &str,
        seeds: &[u64],
        ask: impl Fn(&Observer, f64, &mut ChaCha8Rng) -> Vec<(f64, bool)>,
    ) -> Recovered {
        let (mut ratios, mut inside, mut not) = (Vec::new(), 0, 0);
        for &seed in seeds {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            for k in 0..200 {
                let jnd = 0.25 * 6.4_f64.powf(f64::from(k) / 199.0);
                let observer = Observer::with_jnd(&Stimulus::REFERENCE, jnd, 0.005 * f64::from(k % 5));
                let fit = Fit::new(&levels(ask(&observer, jnd, &mut rng))).expect("answers");
                match fit.threshold {
                    Threshold::Estimated { jnd: found, ci95 } => {
                        ratios.push((found / jnd).ln());
                        inside += usize::from(ci95.0 <= jnd && jnd <= ci95.1);
                    }
                    _ => not += 1,
                }
            }
        }
        let n = ratios.len() as f64;
        let mean = ratios.iter().sum::<f64>() / n;
        let spread = (ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / n).sqrt();
        let (bias, covered) = (mean.exp_m1(), inside as f64 / n);
        println!(
            "{what}: {n} of {} observers estimated ({not} not), bias {:+.2} %, spread {:.1} %, 95 % interval covers {:.1} %",
            200 * seeds.len(),
            100.0 * bias,
            100.0 * spread,
            100.0 * covered
        );
        Recovered { bias, covered, spread, not }
    }

    fn say(observer: &Observer, x: f64, rng: &mut ChaCha8Rng) -> (f64, bool) {
        (
            x,
            rng.random_bool(
                observer.p_correct(&Stimulus::REFERENCE, &Stimulus::REFERENCE.with_levels(2.0 + x, 2.0 + x)),
            ),
        )
    }

    #[test]
    fn constant_stimuli_recover_known_jnds() {
        for seed in [101, 202] {
            let found = recover("constant stimuli, 7 levels × 40", &[seed], |observer, _, rng| {
                let differences = (0..7).map(|k| 0.1 * 50.0_f64.powf(f64::from(k) / 6.0));
                differences.flat_map(|x| (0..40).map(|_| say(observer, x, rng)).collect::<Vec<_>>()).collect()
            });
            assert!(found.not <= 4, "{} not estimated", found.not);
            assert!(found.bias.abs() < 0.05, "bias {}", found.bias);
            assert!((0.90..=0.98).contains(&found.covered), "coverage {}", found.covered);
        }
    }

    #[test]
    fn quest_plus_needs_fewer_answers() {
        // with 200 observers one draw of two cannot separate a coverage of 97 % from 99 %
        let quest = recover("QUEST+, 80 answers", &[303, 304, 305], |observer, _, rng| {
            let mut quest = QuestPlus::new((0.02, 6.0));
            let mut answers = Vec::new();
            for _ in 0..80 {
                let (x, right) = say(observer, quest.next(), rng);
                quest.answer(x, right);
                answers.push((x, right));
            }
            answers
        });
        let constant = |each: usize| {
            recover(
                &format!("constant stimuli over the same range, 8 levels × {each}"),
                &[303],
                |observer, _, rng| {
                    let differences = (0..8).map(|k| 0.02 * 300.0_f64.powf(f64::from(k) / 7.0));
                    differences
                        .flat_map(|x| (0..each).map(|_| say(observer, x, rng)).collect::<Vec<_>>())
                        .collect()
                },
            )
        };
        let (same, twice) = (constant(10), constant(20));
        assert!(quest.bias.abs() < 0.05, "bias {}", quest.bias);
        assert!((0.90..=0.98).contains(&quest.covered), "coverage {}", quest.covered);
        assert!(quest.not <= 60);
        assert!(
            quest.spread < 0.85 * same.spread && quest.spread < 1.1 * twice.spread,
            "about half the answers"
        );
    }

    #[test]
    fn levels_below_the_jnd_give_no_estimate() {
        // like batch 2: nobody answers three of four correctly
        let of = |shares: &[(f64, u32)]| {
            let all: Vec<Level> =
                shares.iter().map(|&(x, correct)| Level { difference_n: x, correct, answers: 38 }).collect();
            Fit::new(&all).expect("a fit").threshold
        };
        let short = of(&[(0.2, 19), (0.6, 20), (1.0, 22), (1.5, 23), (2.0, 25)]);
        println!("{short:?}");
        assert!(
            matches!(short, Threshold::AboveLevels { largest, at_least } if largest == 2.0 && at_least > 1.0)
        );
        let easy = of(&[(0.5, 37), (1.0, 38), (2.0, 38)]);
        println!("{easy:?}");
        assert!(matches!(easy, Threshold::BelowLevels { smallest, .. } if smallest == 0.5));
        let reached = of(&[(0.05, 20), (0.1, 22), (0.2, 24), (0.5, 33), (1.0, 38)]);
        println!("{reached:?}");
        assert!(matches!(reached, Threshold::Estimated { jnd, .. } if (0.2..0.5).contains(&jnd)));
        let few = [Level { difference_n: 0.3, correct: 1, answers: 2 }];
        assert_eq!(Fit::new(&few).map(|fit| fit.threshold), Some(Threshold::TooFew));
        assert_eq!(Fit::new(&[]), None);
    }
}
