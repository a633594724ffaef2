//! A simulated answer: which of two cases differs from the baseline, felt through noise that grows with the level.
//!
//! Of every case the observer has one noisy impression of the dynamic and one of the static friction, with a standard
//! deviation of so many per cent of the level (Weber's law, ch. 5.3.2.2). It names the case whose impression is
//! further from the baseline's, both cues together in units of their noise. For one cue, with σ the noise and Δ the
//! difference, the chance of being right has a closed form, since (A − B) and (A + B − 2·baseline) are independent:
//!
//! p = Φ(Δ/σ√2)·Φ(Δ/σ√6) + Φ(−Δ/σ√2)·Φ(−Δ/σ√6)

use crate::forced_choice::{Case, Presentation};
use crate::psychometric::AT_JND;
use crate::record::Answer;
use crate::stimulus::Stimulus;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// Level below which noise does not shrink any more, N: the unit of the device's own friction.
const FLOOR: f64 = 0.1;

/// A simulated observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observer {
    /// Standard deviation of an impression of dynamic friction, as a share of its level.
    pub weber_dynamic: f64,
    /// Of static friction: a moment at each start, hence larger.
    pub weber_static: f64,
    /// Share of answers given without regard to what was felt.
    pub lapse: f64,
}

impl Observer {
    /// The observer that feels dynamic friction alone and whose JND for both levels raised from `reference` is `jnd` N,
    /// lapses counted.
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

    /// Chance of naming the right case by dynamic friction alone.
    #[must_use]
    pub fn p_correct(&self, reference: &Stimulus, comparison: &Stimulus) -> f64 {
        let noise = self.weber_dynamic * reference.f_dynamic.max(FLOOR);
        let d = (comparison.f_dynamic - reference.f_dynamic).abs() / noise;
        let phi = |z: f64| 0.5 * libm::erfc(-z / std::f64::consts::SQRT_2);
        let (a, b) = (d / 2.0_f64.sqrt(), d / 6.0_f64.sqrt());
        let felt = phi(a) * phi(b) + phi(-a) * phi(-b);
        (1.0 - 2.0 * self.lapse) * felt + self.lapse
    }

    /// Names a case.
    pub fn answer<R: Rng>(&self, shown: &Presentation, rng: &mut R) -> Answer {
        let coin = |rng: &mut R| if rng.random_bool(0.5) { Answer::A } else { Answer::B };
        if rng.random_bool((2.0 * self.lapse).clamp(0.0, 1.0)) {
            return coin(rng);
        }
        let reference = shown.reference;
        // in units of the noise at the reference; a cue of infinite noise tells nothing
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
    fn answers_come_as_often_right_as_the_closed_form_says() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let reference = Stimulus::REFERENCE;
        for jnd in [0.2, 0.5] {
            let observer = Observer::with_jnd(&reference, jnd, 0.01);
            for times in [0.5, 1.0, 2.0] {
                // the closed form has the noise of the baseline: a small difference has nearly that
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
