//! The psychometric function of a forced choice between two: how often the right one is named.
//!
//! ψ(x) = ½ + (½ − λ)·(1 − exp(−k·(x/J)^β)),  k = −ln(1 − ¼/(½ − λ))
//!
//! a Weibull function of the difference x from chance (½) to 1 − λ, written so that ψ(J) = ¾ whatever slope β and lapse
//! rate λ are: J is the just noticeable difference of ch. 5.3.2.7.

use serde::{Deserialize, Serialize};

/// Chance of naming the right one of two without any difference.
pub const GUESS: f64 = 0.5;
/// Share of right answers at the JND (ch. 5.3.2.7).
pub const AT_JND: f64 = 0.75;

/// A psychometric function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Psychometric {
    /// Difference that is named rightly three times in four J, in the unit of the differences.
    pub jnd: f64,
    /// Slope β.
    pub slope: f64,
    /// Share of answers that have nothing to do with what was felt λ, below ¼.
    pub lapse: f64,
}

impl Psychometric {
    /// Probability of the right answer at the difference `x`.
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
    fn the_jnd_is_where_three_of_four_answers_are_right() {
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
