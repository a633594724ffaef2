//! Hayward and Armstrong's friction for haptics: a function of displacement alone, without drift.

use crate::{FrictionLaw, Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

/// α(z) of [thesis, eq. 4.4]: the way a contact yields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Adhesion {
    /// [thesis, eq. 4.6]: static and kinetic friction are equal.
    #[default]
    StickSlide,
    /// [thesis, eq. 4.7]: the contact holds up to z_stick, then slips to z_max.
    StickSlipSlide,
    /// [thesis, eq. 4.8]: like `StickSlipSlide`, with creep under a slow load.
    StickCreepSlipSlide,
}

impl Adhesion {
    /// Every way with its id, as a user types it.
    pub const ALL: [(&'static str, Self); 3] = [
        ("stick_slide", Self::StickSlide),
        ("stick_slip_slide", Self::StickSlipSlide),
        ("stick_creep_slip_slide", Self::StickCreepSlipSlide),
    ];
    /// Every id.
    pub const IDS: &'static str = "stick_slide, stick_slip_slide, stick_creep_slip_slide";

    /// Its id.
    ///
    /// ```
    /// assert_eq!(friction::Adhesion::default().id(), "stick_slide");
    /// ```
    #[must_use]
    pub fn id(self) -> &'static str {
        Self::ALL.iter().find(|(_, way)| *way == self).map_or("", |(id, _)| id)
    }

    /// The way with this id.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == id).map(|(_, way)| *way)
    }
}

described! {
    /// Friction of Hayward and Armstrong [hayward-2000] [thesis, eq. 4.4 to 4.8].
    ///
    /// ```text
    /// dz/dx = 1 − α(z) sgn(dx) z,   F = k z + b v
    /// z_k = x_k − w_(k−1)
    /// w_k = x_k − z_max sgn z_k               where α(z_k) |z_k| > 1   (the contact slips)
    /// w_k = w_(k−1) + |x_k − x_(k−1)| α(z_k) z_k   elsewhere           (it creeps, or holds)
    /// ```
    ///
    /// The force is a function of displacement alone. Position noise below z_max at rest causes no drift, and the length of a
    /// time step has no influence. With `StickSlipSlide` the force is a sawtooth with period z_stick − z_max in *distance*: the
    /// frequency of the rendered stick-slip is v/(z_stick − z_max) and belongs to the interface, as long as the displacement of
    /// a step is smaller than that period.
    ///
    /// ```
    /// use friction::{Adhesion, FrictionLaw, HaywardArmstrong, HaywardArmstrongState, Motion};
    /// let adhesion = Adhesion::StickSlipSlide;
    /// let law = HaywardArmstrong { stiffness: 1e4, dynamic: 3.0, stiction: 3.5, viscous: 0.0, adhesion };
    /// let mut state = HaywardArmstrongState::default();
    /// let slide = |distance| Motion { displacement: distance, ..Motion::default() };
    /// assert!((law.step(&mut state, &slide(3.4e-4)) - 3.4_f64).abs() < 1e-9); // holds
    /// assert!((law.step(&mut state, &slide(0.2e-4)) - 3.0_f64).abs() < 1e-9); // slips
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
    pub struct HaywardArmstrong<S> {
        /// Stiffness of the contact k, N/m.
        pub stiffness: S,
        /// Kinetic friction k z_max, N.
        pub dynamic: S,
        /// Friction k z_stick at which the contact yields, N. At least `dynamic`; not used by `stick_slide`.
        pub stiction: S,
        /// Viscous friction b, N·s/m.
        pub viscous: S,
        /// The way the contact yields.
        pub adhesion: Adhesion,
    }
}

/// State of [`HaywardArmstrong`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HaywardArmstrongState<S> {
    /// Deflection of the contact z = x − w, m.
    pub z: S,
}

impl<S: Scalar> Default for HaywardArmstrongState<S> {
    fn default() -> Self {
        Self { z: S::zero() }
    }
}

impl<S: Scalar> HaywardArmstrong<S> {
    /// α(z), 1/m.
    fn alpha(&self, z: S) -> S {
        let slipping = self.stiffness / self.dynamic;
        let gives_way = |limit: S| if z.abs() * self.stiffness > limit { slipping } else { S::zero() };
        match self.adhesion {
            Adhesion::StickSlide => gives_way(self.dynamic),
            Adhesion::StickSlipSlide => gives_way(self.stiction),
            Adhesion::StickCreepSlipSlide => {
                let ratio = self.stiction / (self.stiffness * z.abs());
                let fourth = ratio * ratio * ratio * ratio;
                slipping / (S::one() + fourth * fourth)
            }
        }
    }
}

impl<S: Scalar> FrictionLaw<S> for HaywardArmstrong<S> {
    type State = HaywardArmstrongState<S>;

    fn step(&self, state: &mut HaywardArmstrongState<S>, motion: &Motion<S>) -> S {
        if !motion.is_finite() {
            return S::lit(f64::NAN);
        }
        let dx = motion.displacement;
        let z = state.z + dx;
        let most = self.dynamic / self.stiffness;
        let zero = S::zero();
        state.z = if z == zero || dx == zero {
            z
        } else if !(most > zero) {
            zero
        } else {
            let alpha = self.alpha(z);
            if alpha * z.abs() > S::one() { most * z.sgn() } else { z - dx.abs() * alpha * z }
        };
        limits::bounded(self.stiffness * state.z + self.viscous * motion.velocity)
    }

    fn stored(&self, state: &Self::State) -> S {
        S::lit(0.5) * self.stiffness * state.z * state.z
    }

    fn validate(&self) -> Result<(), Invalid> {
        in_range("stiffness", self.stiffness, 1e-3, limits::STIFFNESS)?;
        in_range("dynamic", self.dynamic, 0.0, limits::LEVEL)?;
        in_range("stiction", self.stiction, self.dynamic.re(), limits::LEVEL)?;
        in_range("viscous", self.viscous, 0.0, limits::VISCOUS)
    }
}
