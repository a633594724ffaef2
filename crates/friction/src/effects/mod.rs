//! The catalogue: what a complete law leaves out, and what sensors and drives make of a record.
//!
//! Each effect is one file that describes itself ([`About`]) and computes its force, and one line in the `catalogue!`
//! below. Three kinds:
//! * forces ([`EffectKind`]): sample by sample, in any scalar, in the renderer as in a fit ([`Signature`]);
//! * series ([`SeriesKind`]): sensors and drives, which need a whole series (`Operator`, with the feature `alloc`);
//! * others, which are told by other means than a fit, or not at all.
//!
//! Sign and units of a force are those of [`crate::FrictionLaw`]: N, positive against positive motion, to be added to
//! the friction of a law. On a rotary axis read N·m for N and rad for m; [`Parameter::unit`] gives the text. In a recording
//! `Motion.applied` is the measured force and `Motion.mass` is 0.
//!
//! Ranges are physical: a fit that ends outside of one is naming another effect.

use crate::{Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

mod about;
mod name;
#[cfg(feature = "alloc")]
mod series;
mod signature;

pub use about::{
    About, Acts, BOTH, BY_DIRECTION, Comparison, Describe, EITHER, EITHER_OR_BOTH, Example, FIRST_OR_BOTH,
    GainGroups, LookedFor, ONE, Parameter, Quantity, Scale, Seat, Twin,
};
pub use name::EffectName;
#[cfg(feature = "alloc")]
pub use series::{Operator, Record, delayed};
pub use signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};

/// Largest share of the force that an effect moves in time; above it another time constant is meant.
const MOST_SHARE: f64 = 1.3;

macro_rules! catalogue {
    (
        forces { $($(#[$if_force:meta])* $force:ident :: $Force:ident,)* }
        series { $($series:ident :: $Series:ident,)* }
        others { $($other:ident :: $Other:ident,)* }
    ) => {
        $($(#[$if_force])* mod $force; $(#[$if_force])* pub use $force::$Force;)*
        $(mod $series; pub use $series::$Series;)*
        $(mod $other; pub use $other::$Other;)*

        /// Every effect, in the order of the catalogue.
        pub const CATALOGUE: &[&About] = &[
            $($(#[$if_force])* &$Force::ABOUT,)*
            $(&$Series::ABOUT,)*
            $(&$Other::ABOUT,)*
        ];

        /// An effect that is a force.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum EffectKind {
            $(
                $(#[$if_force])*
                #[doc = concat!("See [`", stringify!($Force), "`](struct@", stringify!($Force), ").")]
                $Force,
            )*
        }

        impl EffectKind {
            /// Every force, in the order of the catalogue.
            pub const ALL: &'static [Self] = &[$($(#[$if_force])* Self::$Force,)*];

            /// Its description.
            pub fn about(self) -> &'static About {
                match self { $($(#[$if_force])* Self::$Force => &$Force::ABOUT,)* }
            }
            // Each by itself, so that a device that asks for one is not linked with the whole description.
            /// Its fixed id.
            pub fn id(self) -> &'static str {
                match self { $($(#[$if_force])* Self::$Force => const { $Force::ABOUT.id },)* }
            }
            /// The parameters it is linear in; the first ones of [`Effect::gains`].
            pub fn gains(self) -> &'static [Parameter] {
                match self { $($(#[$if_force])* Self::$Force => const { $Force::ABOUT.gains },)* }
            }
            /// The parameters it is not linear in; the first ones of [`Effect::shape`].
            pub fn shape(self) -> &'static [Parameter] {
                match self { $($(#[$if_force])* Self::$Force => const { $Force::ABOUT.shape },)* }
            }
            /// Whether it is always against the motion ([`About::opposes_motion`]).
            pub fn opposes_motion(self) -> bool {
                match self { $($(#[$if_force])* Self::$Force => const { $Force::ABOUT.opposes_motion },)* }
            }
            /// Whether it is a force of the position, which neither takes nor gives energy on a way there and back, or a part of
            /// the applied force by position.
            pub fn is_of_position(self) -> bool {
                match self { $($(#[$if_force])* Self::$Force => const { of_position(&$Force::ABOUT) },)* }
            }
            /// Whether a machine may have several ([`About::several_by`], [`EffectName`]).
            pub fn may_repeat(self) -> bool {
                match self { $($(#[$if_force])* Self::$Force => const { $Force::ABOUT.several_by.is_some() },)* }
            }
            /// The effect that this shape is rather a case of.
            pub fn rather(self, shape: &[f64; MAX_SHAPE]) -> Option<Self> {
                match self { $($(#[$if_force])* Self::$Force => $Force::rather(shape),)* }
            }
            /// Force per unit of each gain, N per gain unit; advances `memory` by the step. A motion that is not
            /// finite gives NaN and leaves the memory as it was.
            pub fn unit<S: Scalar>(
                self,
                shape: &[S; MAX_SHAPE],
                memory: &mut [S; MAX_MEMORY],
                motion: &Motion<S>,
            ) -> [S; MAX_GAINS] {
                if !motion.is_finite() {
                    return [S::lit(f64::NAN); MAX_GAINS];
                }
                match self { $($(#[$if_force])* Self::$Force => $Force::unit(shape, memory, motion),)* }
            }
            fn check_shape<S: Scalar>(self, shape: &[S; MAX_SHAPE]) -> Result<(), Invalid> {
                match self { $($(#[$if_force])* Self::$Force => $Force::check_shape(shape),)* }
            }
        }

        /// An effect on whole series: of a sensor, an estimator or the drive.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum SeriesKind {
            $(
                #[doc = concat!("See [`", stringify!($Series), "`](struct@", stringify!($Series), ").")]
                $Series,
            )*
        }

        impl SeriesKind {
            /// Every one, in the order of the catalogue.
            pub const ALL: &'static [Self] = &[$(Self::$Series,)*];

            /// Its description.
            #[must_use]
            pub fn about(self) -> &'static About {
                match self { $(Self::$Series => &$Series::ABOUT,)* }
            }
        }

        #[cfg(feature = "alloc")]
        impl SeriesKind {
            /// What a unit of gain `gain` adds to the force that acts, at every sample.
            #[must_use]
            pub fn added(self, gain: usize, shape: &[f64; MAX_SHAPE], record: &Record<'_>) -> alloc::vec::Vec<f64> {
                match self { $(Self::$Series => $Series::added(gain, shape, record),)* }
            }
            /// The force that acts, from the one that is `shown` through a unit of gain `gain`.
            #[must_use]
            pub fn restored(
                self,
                gain: usize,
                shape: &[f64; MAX_SHAPE],
                shown: &[f64],
                dt: f64,
            ) -> alloc::vec::Vec<f64> {
                match self { $(Self::$Series => $Series::restored(gain, shape, shown, dt),)* }
            }
            /// Time by which the force is late as it is, s.
            #[must_use]
            pub fn delay(self, gains: &[f64], shape: &[f64; MAX_SHAPE]) -> f64 {
                match self { $(Self::$Series => $Series::delay(gains, shape),)* }
            }
            /// Time constant of a low-pass that the channel of the force has and those of the motion have not, s.
            #[must_use]
            pub fn low_pass(self, gains: &[f64], shape: &[f64; MAX_SHAPE]) -> Option<f64> {
                match self { $(Self::$Series => $Series::low_pass(gains, shape),)* }
            }
        }
    };
}

catalogue! {
    forces {
        stribeck::Stribeck,
        sublinear_viscous::SublinearViscous,
        quadratic_drag::QuadraticDrag,
        presliding::Presliding,
        frictional_lag::FrictionalLag,
        rising_static_friction::RisingStaticFriction,
        friction_drift::FrictionDrift,
        position_dependent_friction::PositionDependentFriction,
        load_dependent_friction::LoadDependentFriction,
        spring::Spring,
        nonlinear_spring::NonlinearSpring,
        gravity::Gravity,
        cogging::Cogging,
        periodic_friction::PeriodicFriction,
        torque_ripple::TorqueRipple,
        hard_stop::HardStop,
        offset::Offset,
        // at the end: a device keeps a preset's effects by their place in this list
        lost_motion::LostMotion,
        rate_and_state::RateAndState,
        directional_efficiency::DirectionalEfficiency,
        #[cfg(test)] toy::Toy,
    }
    series {
        time_skew::TimeSkew,
        actuator_lag::ActuatorLag,
        velocity_lag::VelocityLag,
        force_gain_asymmetry::ForceGainAsymmetry,
        encoder_eccentricity::EncoderEccentricity,
        compliance::Compliance,
        backlash::Backlash,
        saturation::Saturation,
    }
    others {
        accelerometer_error::AccelerometerError,
        back_emf::BackEmf,
        force_crosstalk::ForceCrosstalk,
        nonlocal_memory::NonlocalMemory,
        cable_hysteresis::CableHysteresis,
        anisotropy::Anisotropy,
        unnamed::Unnamed,
    }
}

/// The description of the effect with this id.
///
/// ```
/// use friction::Geometry::Rotary;
///
/// let spring = friction::effects::about("nonlinear_spring").expect("in the catalogue");
/// let units: Vec<String> = spring.parameters().map(|p| p.unit(Rotary).to_string()).collect();
/// assert_eq!(units, ["N·m/rad³", "N·m/rad²"]);
/// ```
#[must_use]
pub fn about(id: &str) -> Option<&'static About> {
    CATALOGUE.iter().copied().find(|about| about.id == id)
}

/// Whether position and applied force are all that an effect reads.
const fn of_position(about: &About) -> bool {
    let mut k = 0;
    while k < about.reads.len() {
        if !matches!(about.reads[k], Quantity::Position | Quantity::Force) {
            return false;
        }
        k += 1;
    }
    !about.opposes_motion
}

impl EffectKind {
    /// The effect with this id.
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.id() == id)
    }
}

impl SeriesKind {
    /// The effect with this id.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.about().id == id)
    }
}

/// An effect with its parameters. Entries beyond those the effect has are 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Effect<S> {
    /// Which effect.
    pub kind: EffectKind,
    /// Its gains, in the order of [`EffectKind::gains`].
    pub gains: [S; MAX_GAINS],
    /// Its shape, in the order of [`EffectKind::shape`].
    pub shape: [S; MAX_SHAPE],
}

/// What an effect remembers between two steps. `default()` is a body at rest on a fresh contact, at time zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectState<S> {
    /// Words whose meaning is the effect's own.
    pub memory: [S; MAX_MEMORY],
}

impl<S: Scalar> Default for EffectState<S> {
    #[inline(always)] // four of them are made in a control step
    fn default() -> Self {
        Self { memory: [S::zero(); MAX_MEMORY] }
    }
}

impl<S: Scalar> Effect<S> {
    /// The effect without any force: gains 0, and its shape in the middle of its range, the geometric middle where that
    /// spans decades.
    pub fn silent(kind: EffectKind) -> Self {
        let mut effect = Self { kind, gains: [S::zero(); MAX_GAINS], shape: [S::zero(); MAX_SHAPE] };
        for (value, parameter) in effect.shape.iter_mut().zip(kind.shape()) {
            *value = middle(parameter);
        }
        effect
    }

    /// The force of the effect over this step, N, positive against positive motion.
    pub fn step(&self, state: &mut EffectState<S>, motion: &Motion<S>) -> S {
        let unit = self.kind.unit(&self.shape, &mut state.memory, motion);
        let used = self.gains.iter().zip(unit).take(self.kind.gains().len());
        // x³ of an absurd x overflows f32; limited first, it cannot meet a zero gain or its opposite as infinity
        let most = S::lit(1e20);
        limits::bounded(used.fold(S::zero(), |sum, (&gain, unit)| sum + gain * unit.clamp(-most, most)))
    }

    /// The gain or shape parameter of this name.
    pub fn get(&self, name: &str) -> Option<S> {
        let gains = self.kind.gains().iter().zip(&self.gains);
        let shape = self.kind.shape().iter().zip(&self.shape);
        gains.chain(shape).find(|(parameter, _)| parameter.name == name).map(|(_, &value)| value)
    }

    /// The gain or shape parameter of this name, to be set.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut S> {
        let gains = self.kind.gains().iter().zip(&mut self.gains);
        let shape = self.kind.shape().iter().zip(&mut self.shape);
        gains.chain(shape).find(|(parameter, _)| parameter.name == name).map(|(_, value)| value)
    }

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter that is out of range, with the range that would be accepted.
    pub fn validate(&self) -> Result<(), Invalid> {
        check(self.kind.gains(), &self.gains, "unused gain")?;
        check(self.kind.shape(), &self.shape, "unused shape")?;
        self.kind.check_shape(&self.shape)
    }
}

fn check<S: Scalar>(parameters: &[Parameter], values: &[S], unused: &'static str) -> Result<(), Invalid> {
    for (index, &value) in values.iter().enumerate() {
        match parameters.get(index) {
            Some(parameter) => in_range(parameter.name, value, parameter.min, parameter.max)?,
            None => in_range(unused, value, 0.0, 0.0)?,
        }
    }
    Ok(())
}

fn middle<S: Scalar>(parameter: &Parameter) -> S {
    let (min, max) = (S::lit(parameter.min), S::lit(parameter.max));
    if min > S::zero() { (min * max).sqrt() } else { S::lit(0.5) * (min + max) }
}

/// An effect on whole series with its parameters. Entries beyond those the effect has are 0.
///
/// ```
/// use friction::effects::{SeriesEffect, SeriesKind};
///
/// let hard_limit = SeriesEffect { kind: SeriesKind::Saturation, gains: [-1.0, 0.0, 0.0, 0.0], shape: [9.0, 0.0] };
/// assert_eq!(hard_limit.validate(), Ok(()));
/// assert_eq!(hard_limit.get("limit"), Some(9.0)); // N
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeriesEffect {
    /// Which effect.
    pub kind: SeriesKind,
    /// Its gains, in the order of [`About::gains`].
    pub gains: [f64; MAX_GAINS],
    /// Its shape, in the order of [`About::shape`].
    pub shape: [f64; MAX_SHAPE],
}

impl SeriesEffect {
    /// Every parameter with its value.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static Parameter, f64)> + use<> {
        let about = self.kind.about();
        about.gains.iter().zip(self.gains).chain(about.shape.iter().zip(self.shape))
    }

    /// The effect from its parameters by name. None where `value` does not have one of them.
    pub fn from_parameters(kind: SeriesKind, value: impl Fn(&str) -> Option<f64>) -> Option<Self> {
        let mut effect = Self { kind, gains: [0.0; MAX_GAINS], shape: [0.0; MAX_SHAPE] };
        let about = kind.about();
        let places =
            about.gains.iter().zip(&mut effect.gains).chain(about.shape.iter().zip(&mut effect.shape));
        for (parameter, place) in places {
            *place = value(parameter.name)?;
        }
        Some(effect)
    }

    /// The gain or shape parameter of this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<f64> {
        self.parameters().find(|(parameter, _)| parameter.name == name).map(|(_, value)| value)
    }

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter that is out of range, with the range that would be accepted.
    pub fn validate(&self) -> Result<(), Invalid> {
        check(self.kind.about().gains, &self.gains, "unused gain")?;
        check(self.kind.about().shape, &self.shape, "unused shape")
    }

    /// What it adds to the force that acts, at every sample.
    #[cfg(feature = "alloc")]
    #[must_use]
    pub fn added(&self, record: &Record<'_>) -> alloc::vec::Vec<f64> {
        let mut sum = alloc::vec![0.0; record.force.len()];
        for (gain, share) in self.gains.iter().enumerate().take(self.kind.about().gains.len()) {
            if *share != 0.0 {
                for (s, x) in sum.iter_mut().zip(self.kind.added(gain, &self.shape, record)) {
                    *s += share * x;
                }
            }
        }
        sum
    }
}
