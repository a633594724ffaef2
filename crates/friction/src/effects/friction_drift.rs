//! Friction that changes while the machine runs: warm-up, running-in, wear.
//!
//! F = s·force·exp(−t/settling_time), t the time since the start, kept in memory; by direction. A negative force
//! is friction that rises to its final level. With settling_time far beyond the recording it is a linear trend.
//!
//! * Signature: e·s trends in time.
//! * Confused with: sublinear_viscous, when the speeds were visited in order.
//! * Told apart by: random order of the speeds; repeating the first block at the end.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature, by_direction};
use crate::{Motion, Scalar};

/// Drift of friction in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrictionDrift;

impl Signature for FrictionDrift {
    const ID: &'static str = "friction_drift";
    const SAYS: &'static str = "Friction slowly changes while the machine runs, as it warms up or wears.";
    const EQUATION: &'static str = "s*force*exp(-t/settling_time)";
    const GAINS: &'static [Parameter] = &[
        Parameter::new(
            "force_p",
            "N",
            (-1e6, 1e6),
            "friction at the start beyond its final level, positive motion",
        ),
        Parameter::new(
            "force_n",
            "N",
            (-1e6, 1e6),
            "friction at the start beyond its final level, negative motion",
        ),
    ];
    const SHAPE: &'static [Parameter] =
        &[Parameter::new("settling_time", "s", (1e-3, 1e6), "time in which it settles")];

    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [settling_time, _] = *shape;
        // A short time is added to what is left of it, so that hours of steps lose nothing to rounding in f32.
        let [elapsed, rest, ..] = memory;
        let v = motion.velocity;
        let now = (-((*elapsed + *rest) / settling_time)).exp();
        let far = S::lit(1e30); // where nothing is left of it; beyond, f32 would meet ∞ − ∞
        *rest += motion.dt.clamp(S::zero(), far);
        let sum = far.min(*elapsed + *rest);
        *rest -= sum - *elapsed;
        *elapsed = sum;
        by_direction(v, v.sgn() * now)
    }
}
