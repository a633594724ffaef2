//! A simulated observer: which of two cases differs from the baseline, with noise that grows with the level.
//!
//! The observer has one noisy impression of the dynamic and one of the static friction of each case, with a standard
//! deviation proportional to the level (Weber's law, [thesis, ch. 5.3.2.2]). It names the case whose impression is further
//! from that of the baseline, with both cues in units of their noise. For one cue with noise σ and difference Δ the
//! probability of a correct answer has a closed form, because (A − B) and (A + B − 2·baseline) are independent:
//!
//! p = Φ(Δ/σ√2)·Φ(Δ/σ√6) + Φ(−Δ/σ√2)·Φ(−Δ/σ√6)

use crate::forced_choice_plan::{Answer, Case, Presentation};
use crate::psychometric::AT_JND;
use crate::stimulus::Stimulus;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// Level below which the noise is constant, N.
const FLOOR: f64 = 0.1;

/// A simulated observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observer {
    /// Standard deviation of an impression of dynamic friction, as a share of its level.
    pub weber_dynamic: f64,
    /// The same for static friction, which is felt only at each start and therefore larger.
    pub weber_static: f64,
    /// Share of answers independent of the percept.
    pub lapse: f64,
}

impl Observer {
    /// The observer of dynamic friction alone whose JND for both levels raised from `reference` is `jnd`, N, lapses
    /// included.
    #[must_use]
    pub fn with_jnd(reference: &Stimulus, jnd: f64, lapse: f64) -> Self {
        let (mut low, mut high) = (1e-6, 1e3);
        let other = reference.with_levels(reference.f_static + jnd, reference.f_dynamic + jnd);
        for _ in 0..200 {
            let middle = f64::sqrt(low * high);
            let observer = Self { weber_dynamic: middle, weber_static: f64::INFINITY, lapse };
            if observer.p_correct(reference, &other) > AT_JND { low = middle } else { high = middle }
        }
        Self { weber_dynamic: low, weber_static: f64::INFINITY, lapse }
    }

    /// Probability of a correct answer from dynamic friction alone.
    #[must_use]
    pub fn p_correct(&self, reference: &Stimulus, comparison: &Stimulus) -> f64 {
        let noise = self.weber_dynamic * reference.f_dynamic.max(FLOOR);
        let d = (comparison.f_dynamic - reference.f_dynamic).abs() / noise;
        let phi = |z: f64| 0.5 * libm::erfc(-z / std::f64::consts::SQRT_2);
        let (a, b) = (d / 2.0_f64.sqrt(), d / 6.0_f64.sqrt());
        let felt = phi(a) * phi(b) + phi(-a) * phi(-b);
        (1.0 - 2.0 * self.lapse) * felt + self.lapse
    }

    /// Answer of the observer.
    pub fn answer<R: Rng>(&self, shown: &Presentation, rng: &mut R) -> Answer {
        let coin = |rng: &mut R| if rng.random_bool(0.5) { Answer::A } else { Answer::B };
        if rng.random_bool((2.0 * self.lapse).clamp(0.0, 1.0)) {
            return coin(rng);
        }
        let reference = shown.reference;
        // in units of the noise at the reference; a cue of infinite noise is not informative
        let mut draw = |level: f64, reference: f64, weber: f64| {
            let z: f64 = StandardNormal.sample(rng);
            let unit = reference.max(FLOOR);
            if weber.is_finite() { level / (weber * unit) + level.max(FLOOR) / unit * z } else { 0.0 }
        };
        let [baseline, a, b] = [Case::Baseline, Case::A, Case::B].map(|case| {
            let s = shown.stimulus(case);
            [
                draw(s.f_dynamic, reference.f_dynamic, self.weber_dynamic),
                draw(s.f_static, reference.f_static, self.weber_static),
            ]
        });
        let far = |x: [f64; 2]| (x[0] - baseline[0]).hypot(x[1] - baseline[1]);
        match far(a).total_cmp(&far(b)) {
            std::cmp::Ordering::Greater => Answer::A,
            std::cmp::Ordering::Less => Answer::B,
            std::cmp::Ordering::Equal => coin(rng),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::Varied;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn answers_match_the_closed_form() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let reference = Stimulus::REFERENCE;
        for jnd in [0.2, 0.5] {
            let observer = Observer::with_jnd(&reference, jnd, 0.01);
            for times in [0.5, 1.0, 2.0] {
                // the closed form uses the noise of the baseline, nearly that of a small difference
                let comparison = Varied::BothUp.apply(&reference, times * jnd);
                let shown = Presentation {
                    number: 1,
                    batch: String::new(),
                    level: 1,
                    reference,
                    comparison,
                    difference_n: times * jnd,
                    different: Answer::B,
                };
                let n = 20_000;
                let right = (0..n).filter(|_| observer.answer(&shown, &mut rng) == Answer::B).count();
                let (share, closed) =
                    (right as f64 / f64::from(n), observer.p_correct(&reference, &comparison));
                println!("JND {jnd} N, {times} JND apart: {share:.3} right, closed form {closed:.3}");
                assert!((share - closed).abs() < 0.03);
            }
        }
    }
}
