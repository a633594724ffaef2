//! Rate-and-state friction: a jump with the logarithm of the speed, then a decay over a distance.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, Describe, GainGroups, LookedFor, Parameter, Quantity, Scale};
use crate::{Dimension, Motion, Scalar, mean_decay};

/// Reference speed v_0, m/s or rad/s. Another one adds a constant to the friction level.
const REFERENCE: f64 = 1e-3;
/// Speed below which a body counts as at rest: the logarithm ends there.
const REST: f64 = 1e-9;
/// Largest |ln(v·θ/d_c)|.
const FAR: f64 = 40.0;
/// |healing| below which the slip law stands for its neighbours.
const SLIP: f64 = 1e-4;

/// On the measured load, or on the friction level where no load is measured.
const LOAD_OR_LEVEL: GainGroups = &[&[&[0], &[1]], &[&[2], &[3]]];

/// Rate-and-state friction [dieterich-1979] [ruina-1983].
///
/// F = s·(a·ln(|v|/v_0) + b·ln(v_0·θ/d_c))·N beside the friction of a law at v_0 = 1 mm/s (1 mrad/s), s = sgn v, at rest the
/// direction of the applied force. Without a measured load N, `force_a` = a·N and `force_b` = b·N. The contact age θ has a
/// memory of the distance d_c. With u = ln(|v|·θ/d_c) it follows
///
/// ```text
/// du/dx = −(1 − e^(−healing·u))/(healing·d_c)   at constant v
/// ```
///
/// healing = 1 is the ageing law, dθ/dt = 1 − |v|·θ/d_c; healing → 0 the slip law, dθ/dt = −(|v|·θ/d_c)·ln(|v|·θ/d_c).
/// For every healing (|v|·θ/d_c)^healing − 1 decays by e^(−|Δx|/d_c): a step is exact however long it is. A contact begins as
/// one that slid at its first speed.
///
/// ```
/// use friction::Motion;
/// use friction::effects::{Effect, EffectKind, EffectState};
///
/// let rock = Effect { kind: EffectKind::RateAndState, gains: [0.0, 0.0, 0.2, 0.3], shape: [1e-5, 1.0] };
/// let mut state = EffectState::default();
/// let mut slide = |velocity: f64, dt: f64| -> f64 {
///     rock.step(&mut state, &Motion { dt, velocity, displacement: velocity * dt, ..Motion::default() })
/// };
/// assert!(slide(1e-3, 1.0).abs() < 1e-12); // N: steady at v_0
/// assert!((slide(1e-2, 1e-12) - 0.2 * 10_f64.ln()).abs() < 1e-6); // a jump with the sign of a
/// assert!((slide(1e-2, 1.0) - (0.2 - 0.3) * 10_f64.ln()).abs() < 1e-12); // steady again after many d_c
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RateAndState;

impl Describe for RateAndState {
    const ABOUT: About = About {
        id: "rate_and_state",
        says: "After a change of speed friction jumps, then settles over a short distance as the contact renews itself.",
        equation: "s*(a*ln(|v|/v_0) + b*ln(v_0*theta/d_c))*N, force_a = a*N and force_b = b*N without a measured load, v_0 = 1e-3; (|v|*theta/d_c)^healing goes to 1 as exp(-|dx|/d_c)",
        shows: "at a step in speed: a jump with the sign of a, then a decay over the distance d_c",
        confused_with: "stribeck, rising_static_friction",
        told_apart_by: "steps in speed, both ways; slide, hold, slide",
        gains: &[
            Parameter::gain("a", Dimension::FORCE.per(Dimension::LOAD), (0.0, 10.0), "direct effect on the normal load; on an axis times the radius of the contact"),
            Parameter::gain("b", Dimension::FORCE.per(Dimension::LOAD), (-10.0, 10.0), "effect of the contact age on the normal load, below zero in clays; on an axis times the radius of the contact"),
            Parameter::gain("force_a", Dimension::FORCE, (0.0, 1e6), "direct effect where no load is measured"),
            Parameter::gain("force_b", Dimension::FORCE, (-1e6, 1e6), "effect of the contact age where no load is measured"),
        ],
        groups: LOAD_OR_LEVEL,
        shape: &[
            Parameter::shape("d_c", Scale::Distance, (1e-9, 1.0), "distance slid that renews the contact"),
            Parameter::shape("healing", Scale::Range, (-1.0, 2.0), "1: the contact ages at rest (ageing law); 0: only while it slides (slip law)"),
        ],
        reads: &[Quantity::Velocity, Quantity::Displacement, Quantity::Time, Quantity::Force, Quantity::Load],
        opposes_motion: true,
        has_reference: true,
        bench_test: Some("slide in one direction and step the speed up and down, by ten times each"),
        looked_for: LookedFor::WhereItAdvances,
        ..About::EFFECT
    };
}

/// ln(|v|·θ/d_c) after `q` distances d_c at constant speed.
fn settled<S: Scalar>(u: S, healing: S, q: S) -> S {
    if healing.abs() < S::lit(SLIP) {
        return u * (-q).exp();
    }
    let one = S::one();
    let z = (healing * u).exp();
    // 1 + (z − 1)·e^(−q), each side of 1 without a difference that could cancel to nothing
    let after = if z > one { one + (z - one) * (-q).exp() } else { z + (one - z) * (q * mean_decay(q)) };
    after.ln() / healing
}

impl Signature for RateAndState {
    fn unit<S: Scalar>(
        &[d_c, healing]: &[S; MAX_SHAPE],
        memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let (zero, one) = (S::zero(), S::one());
        let [age, begun, ..] = memory; // ln(v_0·θ/d_c)
        let rate = |speed: S| (speed.abs().clamp(S::lit(REST), S::lit(1.0 / REST)) / S::lit(REFERENCE)).ln();
        let (v, dt) = (motion.velocity, motion.dt);
        // The contact renews by what it slides: a velocity from another source would let it age while it does. The first sample
        // of a recording has a velocity, but nothing slid before it.
        let slid_before = motion.displacement != zero || *begun != zero;
        let mean = rate(if dt > zero && slid_before { motion.displacement / dt } else { v });
        if *begun == zero {
            *begun = one;
            *age = if v == zero { zero } else { -mean };
        }
        let slid = motion.displacement.abs().max(S::lit(REST) * dt.max(zero));
        let far = S::lit(FAR);
        let u = (mean + *age).clamp(-far, far);
        // beyond a million distances nothing is left, and infinity times 0 would be NaN
        *age = settled(u, healing, (slid / d_c).min(S::lit(1e6))) - mean;
        let s = if v == zero { motion.applied } else { v }.sgn();
        let (direct, aged) = (s * rate(v), s * *age);
        match motion.normal {
            Some(load) => [load * direct, load * aged, zero, zero],
            None => [zero, zero, direct, aged],
        }
    }
}
