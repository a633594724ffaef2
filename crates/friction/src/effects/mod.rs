//! The catalogue of physics that a complete law leaves out. Each effect is one file, a force that is linear in
//! its gains once its shape is given, and one line in the `catalogue!` below.
//!
//! Sign and units are those of [`crate::FrictionLaw`]: N, positive against positive motion, to be added to
//! the friction of a law. On a rotary axis read N·m for N and rad for m. In a recording `Motion.applied` is the
//! measured force and `Motion.mass` is 0.
//!
//! Ranges are physical: a fit that ends outside of one is naming another effect.

use crate::{Invalid, Motion, Scalar, in_range, limits};
use serde::{Deserialize, Serialize};

mod signature;

pub use signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Parameter, Signature};

macro_rules! catalogue {
    ($($module:ident :: $Effect:ident,)*) => {
        $(
            mod $module;
            pub use $module::$Effect;
        )*

        /// Which effect.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum EffectKind {
            $(
                #[doc = concat!("See [`", stringify!($Effect), "`](struct@", stringify!($Effect), ").")]
                $Effect,
            )*
        }

        impl EffectKind {
            /// Every effect, in the order of the catalogue.
            pub const ALL: &'static [Self] = &[$(Self::$Effect,)*];

            /// Its fixed id.
            pub fn id(self) -> &'static str {
                match self { $(Self::$Effect => <$Effect as Signature>::ID,)* }
            }
            /// One plain sentence for a person.
            pub fn says(self) -> &'static str {
                match self { $(Self::$Effect => <$Effect as Signature>::SAYS,)* }
            }
            /// Its equation as text.
            pub fn equation(self) -> &'static str {
                match self { $(Self::$Effect => <$Effect as Signature>::EQUATION,)* }
            }
            /// The parameters it is linear in; the first ones of [`Effect::gains`].
            pub fn gains(self) -> &'static [Parameter] {
                match self { $(Self::$Effect => <$Effect as Signature>::GAINS,)* }
            }
            /// The parameters it is not linear in; the first ones of [`Effect::shape`].
            pub fn shape(self) -> &'static [Parameter] {
                match self { $(Self::$Effect => <$Effect as Signature>::SHAPE,)* }
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
                match self { $(Self::$Effect => <$Effect as Signature>::unit(shape, memory, motion),)* }
            }
            fn check_shape<S: Scalar>(self, shape: &[S; MAX_SHAPE]) -> Result<(), Invalid> {
                match self { $(Self::$Effect => <$Effect as Signature>::check_shape(shape),)* }
            }
        }
    };
}

catalogue! {
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
}

impl EffectKind {
    /// Always against the motion, and nothing at rest but where it adds to break-away: a part of the friction level.
    /// The others are springs, loads or have a memory that pushes back.
    pub fn opposes_motion(self) -> bool {
        matches!(
            self,
            Self::Stribeck
                | Self::SublinearViscous
                | Self::QuadraticDrag
                | Self::RisingStaticFriction
                | Self::FrictionDrift
                | Self::PositionDependentFriction
                | Self::LoadDependentFriction
                | Self::PeriodicFriction
        )
    }

    /// The effect with this id.
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.id() == id)
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
