//! Friction that changes while the machine runs: warm-up, running-in, wear.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature, by_direction};
use super::{About, Describe, Parameter, BY_DIRECTION, Example, Quantity, Scale};
use crate::{Dimension, Motion, Scalar};

/// Drift of friction in time.
///
/// F = s·force·exp(−t/settling_time), t the time since the start, kept in memory; by direction. A negative force
/// is friction that rises to its final level. With settling_time far beyond the recording it is a linear trend.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let warming = Effect { kind: EffectKind::FrictionDrift, gains: [0.6, 0.6, 0.0, 0.0], shape: [6.0, 0.0] };
/// let mut state = EffectState::default();
/// warming.step(&mut state, &Motion { dt: 6.0, velocity: 0.1, ..Motion::default() });
/// let force: f64 = warming.step(&mut state, &Motion { velocity: 0.1, ..Motion::default() });
/// assert!((force - 0.6 / std::f64::consts::E).abs() < 1e-12); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrictionDrift;

impl Describe for FrictionDrift {
    const ABOUT: About = About {
        id: "friction_drift",
        says: "Friction slowly changes while the machine runs, as it warms up or wears.",
        equation: "s*force*exp(-t/settling_time)",
        shows: "a trend in time that has the sign of the velocity",
        confused_with: "sublinear_viscous, when the speeds were visited in order",
        told_apart_by: "random order of the speeds; repeating the first block at the end",
        gains: &[
            Parameter::gain("force_p", Dimension::FORCE, (-1e6, 1e6), "friction at the start beyond its final level, positive motion"),
            Parameter::gain("force_n", Dimension::FORCE, (-1e6, 1e6), "friction at the start beyond its final level, negative motion"),
        ],
        groups: BY_DIRECTION,
        shape: &[Parameter::shape("settling_time", Scale::Duration, (1e-3, 1e6), "time in which it settles")],
        reads: &[Quantity::Velocity, Quantity::Time],
        opposes_motion: true,
        example: Some(Example { gains: [0.6, 0.6, 0.0, 0.0], shape: [6.0, 0.0] }),
        ..About::EFFECT
    };
}

impl Signature for FrictionDrift {
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
