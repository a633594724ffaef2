//! The psychometric function of a forced choice between two: probability of a correct answer.
//!
//! ψ(x) = ½ + (½ − λ)·(1 − exp(−k·(x/J)^β)),  k = −ln(1 − ¼/(½ − λ))
//!
//! is a Weibull function of the difference x from chance (½) to 1 − λ. It is written such that ψ(J) = ¾ for every slope β and
//! lapse rate λ: J is the just noticeable difference of [thesis, ch. 5.3.2.7].

use serde::{Deserialize, Serialize};

/// Probability of a correct answer without any difference.
pub const GUESS: f64 = 0.5;
/// Probability of a correct answer at the JND [thesis, ch. 5.3.2.7].
pub const AT_JND: f64 = 0.75;

/// A psychometric function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Psychometric {
    /// Just noticeable difference J, in the unit of the differences.
    pub jnd: f64,
    /// Slope β.
    pub slope: f64,
    /// Lapse rate λ, the share of answers independent of the percept. Below ¼.
    pub lapse: f64,
}

impl Psychometric {
    /// Probability of a correct answer at the difference `x`.
    #[must_use]
    pub fn p(&self, x: f64) -> f64 {
        let reach = 1.0 - GUESS - self.lapse;
        let k = -(1.0 - (AT_JND - GUESS) / reach).ln();
        GUESS + reach * -(-k * (x / self.jnd).powf(self.slope)).exp_m1()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_of_four_are_correct_at_the_jnd() {
        for slope in [0.8, 1.5, 4.0] {
            for lapse in [0.0, 0.02, 0.1] {
                let f = Psychometric { jnd: 0.7, slope, lapse };
                assert!((f.p(0.7) - 0.75).abs() < 1e-14);
                assert!((f.p(0.0) - 0.5).abs() < 1e-14);
                assert!((f.p(1e6) - (1.0 - lapse)).abs() < 1e-9);
                assert!(f.p(0.3) < f.p(0.5));
            }
        }
    }
}
