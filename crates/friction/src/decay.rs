//! Mean of an exponential decay.

use crate::Scalar;

/// Mean of e^−x from 0 to q, (1 − e^−q)/q, for q ≥ 0. Smooth through q = 0, where the difference would cancel.
///
/// ```
/// assert_eq!(friction::mean_decay(0.0_f64), 1.0);
/// assert!((friction::mean_decay(1.0_f64) - 0.632_120_558_828_557_7).abs() < 1e-15);
/// ```
pub fn mean_decay<S: Scalar>(q: S) -> S {
    let one = S::one();
    if q < S::lit(1e-2) {
        // next term q⁴/120: below 1e-10
        one - q * (S::lit(0.5) - q * (S::lit(1.0 / 6.0) - q * S::lit(1.0 / 24.0)))
    } else {
        (one - (-q).exp()) / q
    }
}
