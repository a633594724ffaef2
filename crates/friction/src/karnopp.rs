//! Karnopp friction with separate levels for each direction.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

described! {
    /// Modified Karnopp friction [karnopp-1985] [thesis, eq. 3.1]. All levels are magnitudes; the source prints C_n and
    /// D_n as negative numbers.
    ///
    /// ```text
    /// v >  Δv   F =  C_p + b_p v
    /// v < −Δv   F = −C_n + b_n v
    /// |v| ≤ Δv  F = the force that brings the body to rest, limited to [−D_n, D_p]
    /// ```
    ///
    /// The stuck branch differs from the printed one, `min(D_p, F_a)` or `max(D_n, F_a)` by the sign of v. The printed
    /// branch is undefined at v = 0, unbounded when F_a opposes v, and lets a body that enters the band at 0.9 Δv keep that
    /// velocity. Here the band is one branch with both limits. Where the mass is known the branch *stops* the body:
    /// F = clamp(m v / dt + F_a, −D_n, D_p). With `mass = 0` it balances F_a.
    ///
    /// The sliding branch is as printed. It has Karnopp's zero-crossing limit cycle when Δv is too small for the time step:
    /// C dt / m > 2 Δv for a free mass, [thesis, eq. 4.21] for a rendered one. [`crate::Coulomb`] has no limit cycle.
    ///
    /// ```
    /// use friction::{FrictionLaw, Karnopp, Motion};
    /// // aluminium on rubber, [thesis, table 3-3]
    /// let rubber = Karnopp { c_p: 3.4901, c_n: 2.5611, b_p: 8.7338, b_n: 7.9521, d_p: 3.8513, d_n: 2.9099, delta_v: 0.02 };
    /// let sliding = Motion { velocity: 0.1, ..Motion::default() };
    /// assert!((rubber.step(&mut (), &sliding) - 4.36348_f64).abs() < 1e-12);
    /// let pushed = Motion { applied: 2.0, ..Motion::default() };
    /// assert_eq!(rubber.step(&mut (), &pushed), 2.0); // stuck: friction balances the load
    /// let pulled_loose = Motion { applied: 9.0, ..Motion::default() };
    /// assert_eq!(rubber.step(&mut (), &pulled_loose), 3.8513); // break-away
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct Karnopp<S> {
        /// Dynamic friction in positive motion, C_p, N.
        pub c_p: S,
        /// Dynamic friction in negative motion, magnitude of C_n, N.
        pub c_n: S,
        /// Viscous friction in positive motion, b_p, N·s/m. Negative where friction falls with speed, as on brass.
        pub b_p: S,
        /// Viscous friction in negative motion, b_n, N·s/m.
        pub b_n: S,
        /// Static friction against positive motion, D_p, N.
        pub d_p: S,
        /// Static friction against negative motion, magnitude of D_n, N.
        pub d_n: S,
        /// Half-width of the band of velocities treated as zero, Δv, m/s.
        pub delta_v: S,
    }
}

impl<S: Scalar> Karnopp<S> {
    /// Whether `velocity` lies in the band that is treated as zero.
    ///
    /// ```
    /// let law = friction::Karnopp { c_p: 1.0, c_n: 1.0, b_p: 0.0, b_n: 0.0, d_p: 1.2, d_n: 1.2, delta_v: 0.007 };
    /// assert!(law.is_stuck(-0.007) && !law.is_stuck(0.0071));
    /// ```
    pub fn is_stuck(&self, velocity: S) -> bool {
        velocity <= self.delta_v && velocity >= -self.delta_v
    }
}

impl<S: Scalar> FrictionLaw<S> for Karnopp<S> {
    type State = ();

    #[inline(always)] // part of nearly every control step
    fn step(&self, (): &mut (), motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let v = motion.velocity;
        limits::bounded(if self.is_stuck(v) {
            motion.stopping_force().clamp(-self.d_n, self.d_p)
        } else if v > S::zero() {
            limits::sliding(self.c_p, self.b_p, v)
        } else {
            -limits::sliding(self.c_n, self.b_n, -v)
        })
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("c_p", self.c_p, 0.0, limits::LEVEL)?;
        in_range("c_n", self.c_n, 0.0, limits::LEVEL)?;
        in_range("b_p", self.b_p, -limits::VISCOUS, limits::VISCOUS)?;
        in_range("b_n", self.b_n, -limits::VISCOUS, limits::VISCOUS)?;
        in_range("d_p", self.d_p, 0.0, limits::LEVEL)?;
        in_range("d_n", self.d_n, 0.0, limits::LEVEL)?;
        in_range("delta_v", self.delta_v, 0.0, 10.0)
    }
}
