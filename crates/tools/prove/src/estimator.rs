//! A first-order estimator of velocity, as boards have it.

use crate::scale::RATE;

/// What a first-order estimator with this time constant, s, keeps of its state in a sample.
pub(crate) fn estimator(time: f64) -> f64 {
    (-1.0 / (RATE * time)).exp()
}

/// How late that makes a ramp, s: less than the time constant, as it sees each sample when it comes.
pub(crate) fn estimator_delay(time: f64) -> f64 {
    let keep = estimator(time);
    keep / (1.0 - keep) / RATE
}
