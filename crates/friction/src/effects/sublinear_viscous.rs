//! Viscous friction that levels off with speed: the lubricant shears thin, or the film builds up.
//!
//! F = s·force·(1 − exp(−(|v|/v_0)^power)), s = sgn v; by direction. For |v| ≪ v_0 this is the power law
//! s·(|v|/v_0)^power, for |v| ≫ v_0 a level. With a power above 1 it is, beside a free viscous part, friction that falls:
//! a diagnosis prefers stribeck then.
//!
//! * Signature: odd in v, steep at low speed: friction *falls* toward rest.
//! * Confused with: stribeck with the other sign (the same curve if a Coulomb level is free; hence both gains
//!   are ≥ 0), quadratic_drag (.80-.93).
//! * Told apart by: constant speeds over two decades.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature, by_direction};
use crate::{Motion, Scalar};

/// Viscous friction that levels off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SublinearViscous;

impl Signature for SublinearViscous {
    const ID: &'static str = "sublinear_viscous";
    const SAYS: &'static str = "Friction grows with speed at first, then levels off.";
    const EQUATION: &'static str = "s*force*(1 - exp(-(|v|/v_0)^power))";
    const GAINS: &'static [Parameter] = &[
        Parameter::new("force_p", "N", (0.0, 1e6), "friction gained at high speed in positive motion"),
        Parameter::new("force_n", "N", (0.0, 1e6), "friction gained at high speed in negative motion"),
    ];
    const SHAPE: &'static [Parameter] = &[
        Parameter::new("v_0", "m/s", (1e-6, 1e2), "speed at which it levels off"),
        Parameter::new("power", "1", (0.2, 2.0), "power of the speed below v_0"),
    ];

    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [v_0, power] = *shape;
        let v = motion.velocity;
        let risen = S::one() - (-(v.abs() / v_0).powf(power)).exp();
        by_direction(v, v.sgn() * risen)
    }
}
