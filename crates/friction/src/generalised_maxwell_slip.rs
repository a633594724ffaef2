//! Generalised Maxwell slip: parallel springs and sliders whose sliding level depends on speed.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// Number of elements of [`MaxwellSlip`].
pub const ELEMENTS: usize = 6;

described! {
    /// Generalised Maxwell slip [al-bender-2005] with six elements.
    ///
    /// ```text
    /// sticking:  dF_i/dt = k_i v            until |F_i| = ν_i g(v)
    /// slipping:  dF_i/dt = s C (ν_i − s F_i/g(v))   until v changes sign
    /// F = Σ F_i + σ₂ v,   g(v) = F_c + (F_s − F_c) exp(−(v/v_s)²)
    /// ```
    ///
    /// The only law of this crate with non-local memory: when an inner hysteresis loop closes, the force continues along the
    /// outer one. At constant speed the slipping equation is solved exactly over the step.
    ///
    /// ```
    /// use friction::{FrictionLaw, MaxwellSlip, MaxwellSlipState, Motion};
    /// let law = MaxwellSlip::new(3.0, 1e-4);
    /// let mut state = MaxwellSlipState::default();
    /// let slide = |distance| Motion { dt: 1e-3, displacement: distance, ..Motion::default() };
    /// // 2.75 presliding lengths: every element slips
    /// assert!((law.step(&mut state, &slide(2.75e-4)) - 3.0_f64).abs() < 1e-12);
    /// // a closed inner loop returns to where it began
    /// let outer = law.step(&mut state, &slide(-1e-4));
    /// law.step(&mut state, &slide(2e-5));
    /// assert!((law.step(&mut state, &slide(-2e-5)) - outer).abs() < 1e-12);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct MaxwellSlip<S> {
        /// Stiffness k_i as a share of F_c, 1/m.
        pub stiffness: [S; ELEMENTS],
        /// Shares ν_i of the sliding level. They sum to 1.
        pub share: [S; ELEMENTS],
        /// Coulomb level F_c, N.
        pub coulomb: S,
        /// Stiction F_s, N. At least `coulomb`.
        pub stiction: S,
        /// Stribeck velocity v_s, m/s.
        pub stribeck_velocity: S,
        /// Attraction C, the rate at which a slipping element follows the level, N/s.
        pub attraction: S,
        /// Viscous friction σ₂, N·s/m.
        pub viscous: S,
    }
}

/// State of [`MaxwellSlip`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaxwellSlipState<S> {
    /// Force of each element F_i, N.
    pub force: [S; ELEMENTS],
    /// Direction in which each element slips, 0 for one that sticks.
    pub slips: [i8; ELEMENTS],
}

impl<S: Scalar> Default for MaxwellSlipState<S> {
    fn default() -> Self {
        Self { force: [S::zero(); ELEMENTS], slips: [0; ELEMENTS] }
    }
}

impl<S: Scalar> MaxwellSlip<S> {
    /// A contact whose virgin curve follows 1 − e^(−x/`presliding`), with `presliding` in m. No Stribeck effect and no
    /// viscous friction.
    ///
    /// Element i slips at the deflection x_i = x_s (2i + 1)/4. ν and k are chosen such that the virgin curve
    /// Σ min(k_i x, ν_i) passes through (1 − e^(−x/x_s))/(1 − e^(−x_5/x_s)) at every x_i and is 1 beyond x_5.
    ///
    /// ```
    /// let law = friction::MaxwellSlip::new(3.0_f64, 1e-4);
    /// assert!((law.share.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    /// ```
    pub fn new(coulomb: S, presliding: S) -> Self {
        let apart = presliding / S::lit(2.0);
        let knot = |i: usize| apart * S::lit(i as f64 + 0.5);
        let shape = |x: S| S::one() - (-(x / presliding)).exp();
        let whole = shape(knot(ELEMENTS - 1));
        let virgin = |x: S| shape(x) / whole;
        // slope of the virgin curve between knots: the stiffness of the elements that still stick
        let slope = |i: usize| match i {
            0 => virgin(knot(0)) / knot(0),
            i if i < ELEMENTS => (virgin(knot(i)) - virgin(knot(i - 1))) / apart,
            _ => S::zero(),
        };
        let stiffness = core::array::from_fn(|i| slope(i) - slope(i + 1));
        let share = core::array::from_fn(|i| (slope(i) - slope(i + 1)) * knot(i));
        Self {
            stiffness,
            share,
            coulomb,
            stiction: coulomb,
            stribeck_velocity: S::lit(0.01),
            attraction: S::lit(1e3) * coulomb.max(S::lit(1e-3)),
            viscous: S::zero(),
        }
    }

    /// A contact whose virgin curve begins with the stiffness `sigma`, N/m.
    ///
    /// ```
    /// let law = friction::MaxwellSlip::of_stiffness(3.0_f64, 1e4);
    /// assert!((law.initial_stiffness() - 1e4).abs() < 1e-6);
    /// ```
    pub fn of_stiffness(coulomb: S, sigma: S) -> Self {
        // any positive level: without friction the stiffness is zero, and 0/0 is NaN
        let level = coulomb.max(S::lit(1e-3));
        let share = Self::new(level, S::one()).initial_stiffness();
        let law = Self::new(level, share / sigma);
        Self { coulomb, stiction: coulomb, ..law }
    }

    /// Stiffness of the contact while every element sticks, N/m.
    pub fn initial_stiffness(&self) -> S {
        self.coulomb * self.stiffness.iter().fold(S::zero(), |sum, &k| sum + k)
    }

    /// Sliding level g(v) without the viscous part, N.
    ///
    /// ```
    /// let law = friction::MaxwellSlip { stiction: 3.6, ..friction::MaxwellSlip::new(3.0, 1e-4) };
    /// assert_eq!((law.level(0.0), law.level(1.0)), (3.6, 3.0));
    /// ```
    pub fn level(&self, velocity: S) -> S {
        limits::stribeck(self.coulomb, self.stiction, velocity, self.stribeck_velocity)
    }
}

impl<S: Scalar> FrictionLaw<S> for MaxwellSlip<S> {
    type State = MaxwellSlipState<S>;

    fn step(&self, state: &mut MaxwellSlipState<S>, motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let (dx, zero) = (motion.displacement, S::zero());
        let level = self.level(motion.velocity);
        let follows =
            if level > zero { (-(self.attraction * motion.dt.max(zero) / level)).exp() } else { zero };
        let (direction, sign): (i8, S) = if dx > zero {
            (1, S::one())
        } else if dx < zero {
            (-1, -S::one())
        } else {
            (0, zero)
        };
        let mut sum = zero;
        let elements =
            self.stiffness.iter().zip(&self.share).zip(state.force.iter_mut().zip(&mut state.slips));
        for ((&stiffness, &share), (force, slips)) in elements {
            let limit = share * level;
            if direction == 0 {
                // at rest nothing changes; a slipping element continues with the motion
            } else if *slips == direction {
                let end = sign * limit;
                *force = end + (*force - end) * follows;
            } else {
                *slips = 0;
                let stretched = *force + stiffness * self.coulomb * dx;
                *force = if sign * stretched >= limit {
                    *slips = direction;
                    sign * limit
                } else {
                    stretched
                };
            }
            sum += *force;
        }
        limits::bounded(sum + self.viscous * motion.velocity)
    }

    fn stored(&self, state: &Self::State) -> S {
        let elements = self.stiffness.iter().zip(&state.force);
        let twice = elements.fold(S::zero(), |sum, (&stiffness, &force)| {
            let stiffness = stiffness * self.coulomb;
            if stiffness > S::zero() { sum + force * force / stiffness } else { sum }
        });
        S::lit(0.5) * twice
    }

    fn validate(&self) -> Result<(), Invalid> {
        for (&stiffness, &share) in self.stiffness.iter().zip(&self.share) {
            in_range("stiffness", stiffness, 0.0, limits::STIFFNESS)?;
            in_range("share", share, 0.0, 1.0)?;
        }
        in_range("coulomb", self.coulomb, 0.0, limits::LEVEL)?;
        in_range("stiction", self.stiction, self.coulomb.re(), limits::LEVEL)?;
        in_range("stribeck_velocity", self.stribeck_velocity, 1e-6, 1e3)?;
        in_range("attraction", self.attraction, 0.0, limits::STIFFNESS)?;
        in_range("viscous", self.viscous, 0.0, limits::VISCOUS)
    }
}
