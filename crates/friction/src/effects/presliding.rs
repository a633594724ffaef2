//! The contact gives elastically before it slides: friction turns round over a distance, not at once.
//!
//! dz/dx = (1 − s_x·z)/x_s with s_x = sgn dx (the unit Dahl model, stepped exactly over the displacement);
//! F = force·(z − sgn v); by direction.
//!
//! The sgn v is taken off because it is already in the baseline: Coulomb friction C·sgn v plus force = C is a
//! full Dahl model of limit C and stiffness C/x_s. After a reversal the unit is −2·s and dies out over x_s; at rest
//! it is z, what the bristles hold. With different Coulomb levels both gains are their mean.
//!
//! * Signature: a lobe that decays with *distance* after each reversal, at any rate.
//! * Confused with: its own variants (LuGre, elasto-plastic: .99, one class), frictional_lag (.89), rising_static_friction
//!   (.96).
//! * Told apart by: micro-reversals; moves with dwells (.13).

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature, bristle, by_direction};
use crate::{Motion, Scalar};

/// Presliding displacement (Dahl).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Presliding;

impl Signature for Presliding {
    const ID: &'static str = "presliding";
    const SAYS: &'static str = "After each reversal friction builds up over a short distance instead of at once, like a spring between the surfaces.";
    const EQUATION: &'static str = "force*(z - s), dz/dx = (1 - s*z)/x_s";
    const GAINS: &'static [Parameter] = &[
        Parameter::new(
            "force_p",
            "N",
            (0.0, 1e6),
            "friction that turns round elastically in positive motion",
        ),
        Parameter::new(
            "force_n",
            "N",
            (0.0, 1e6),
            "friction that turns round elastically in negative motion",
        ),
    ];
    const SHAPE: &'static [Parameter] =
        &[Parameter::new("x_s", "m", (1e-8, 1.0), "distance over which friction turns round")];

    fn unit<S: Scalar>(
        shape: &[S; MAX_SHAPE],
        memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let [x_s, _] = *shape;
        let [z, direction, ..] = memory;
        let s = motion.velocity.sgn();
        *z = bristle(*z, motion.displacement, x_s);
        if s != S::zero() {
            *direction = s; // at rest the bristles hold with the gain they were bent with
        }
        by_direction(*direction, *z - s)
    }
}
