//! What an exponential decay leaves on the mean.

use crate::Scalar;

/// (1 − e^−q)/q for q ≥ 0, the mean of e^−x from 0 to q, smooth through q = 0: the difference cancels there.
pub fn mean_decay<S: Scalar>(q: S) -> S {
    let one = S::one();
    if q < S::lit(1e-2) {
        // next term q⁴/120: below 1e-10
        one - q * (S::lit(0.5) - q * (S::lit(1.0 / 6.0) - q * S::lit(1.0 / 24.0)))
    } else {
        (one - (-q).exp()) / q
    }
}
