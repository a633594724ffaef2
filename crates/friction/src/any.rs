//! A law chosen at run time, as a preset names it.

use crate::{
    Armstrong, ArmstrongState, Bristle, BristleState, Classic, Coulomb, CoulombState, Dahl, DahlState,
    ElastoPlastic, ElastoPlasticState, FrictionLaw, HaywardArmstrong, HaywardArmstrongState, Invalid,
    Karnopp, LuGre, LuGreState, MajdSimaan, MaxwellSlip, MaxwellSlipState, Motion, Scalar, Viscous,
};
use serde::{Deserialize, Serialize};

/// Number of bonds of a [`Bristle`] contact that is chosen at run time: what a microcontroller steps within 10 µs.
pub const BONDS: usize = 6;

/// Defines [`Law`] with its ids and states.
macro_rules! laws {
    (
        without memory { $($plain:ident, $plain_step:ident, $plain_id:literal;)* }
        with memory { $($Law:ident, $Type:ty, $State:ty, $step:ident, $id:literal;)* }
    ) => {
        /// A law chosen at run time.
        ///
        /// ```
        /// use friction::{FrictionLaw, Law, LawState, LuGre, Motion};
        /// let law = Law::LuGre(LuGre {
        ///     sigma_0: 1e5, sigma_1: 0.0, sigma_2: 0.0, coulomb: 1.0, stiction: 1.0, stribeck_velocity: 1e-3,
        /// });
        /// let mut state = LawState::default();
        /// let force: f64 = law.step(&mut state, &Motion { displacement: 1e-2, ..Motion::default() });
        /// assert!((force - 1.0).abs() < 1e-12);
        /// assert_eq!(law.id(), "lugre");
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        pub enum Law<S> {
            /// See [`Karnopp`].
            #[serde(rename = "karnopp")]
            Karnopp(Karnopp<S>),
            $(#[doc = concat!("See [`", stringify!($plain), "`].")]
            #[serde(rename = $plain_id)]
            $plain($plain<S>),)*
            $(#[doc = concat!("See [`", stringify!($Law), "`].")]
            #[serde(rename = $id)]
            $Law($Type),)*
        }

        /// State of a [`Law`]. A law given the state of another law starts from a fresh contact.
        ///
        /// ```
        /// assert_eq!(friction::LawState::<f32>::default(), friction::LawState::Fresh);
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub enum LawState<S> {
            /// No memory: the state of a law without one, and the start of every law.
            #[default]
            Fresh,
            $(#[doc = concat!("State of [`", stringify!($Law), "`].")]
            $Law($State),)*
        }

        impl<S> Law<S> {
            /// Which law it is.
            pub fn kind(&self) -> LawKind {
                match self {
                    Self::Karnopp(_) => LawKind::Karnopp,
                    $(Self::$plain(_) => LawKind::$plain,)*
                    $(Self::$Law(_) => LawKind::$Law,)*
                }
            }

            /// Id of the law, as a user types it.
            pub fn id(&self) -> &'static str {
                self.kind().id()
            }
        }

        impl LawKind {
            /// Id of the law, as a user types it.
            #[must_use]
            pub const fn id(self) -> &'static str {
                match self {
                    Self::Karnopp => "karnopp",
                    $(Self::$plain => $plain_id,)*
                    $(Self::$Law => $id,)*
                }
            }
        }

        /// Each law has a function of its own: in a common one every law would save the registers that any of them
        /// needs, which costs a twentieth of a control step.
        impl<S: Scalar> LawState<S> {
            $(#[inline(never)]
            fn $plain_step(&mut self, law: &$plain<S>, motion: &Motion<S>) -> S {
                *self = Self::Fresh;
                law.step(&mut (), motion)
            })*
            $(#[inline(never)]
            fn $step(&mut self, law: &$Type, motion: &Motion<S>) -> S {
                // in place: a copy there and back costs as much as an exponential
                if !matches!(self, Self::$Law(_)) {
                    *self = Self::$Law(Default::default());
                }
                if let Self::$Law(own) = self { law.step(own, motion) } else { S::zero() }
            })*
        }

        impl<S: Scalar> FrictionLaw<S> for Law<S> {
            type State = LawState<S>;

            // inline: every built-in preset uses Karnopp, and in a common function it would save the registers of the
            // others
            #[inline(always)]
            fn step(&self, state: &mut LawState<S>, motion: &Motion<S>) -> S {
                match self {
                    Self::Karnopp(law) => {
                        *state = LawState::Fresh;
                        law.step(&mut (), motion)
                    }
                    $(Self::$plain(law) => state.$plain_step(law, motion),)*
                    $(Self::$Law(law) => state.$step(law, motion),)*
                }
            }

            fn stored(&self, state: &LawState<S>) -> S {
                match (self, state) {
                    $((Self::$Law(law), LawState::$Law(own)) => law.stored(own),)*
                    _ => S::zero(),
                }
            }

            fn validate(&self) -> Result<(), Invalid> {
                match self {
                    Self::Karnopp(law) => law.validate(),
                    $(Self::$plain(law) => law.validate(),)*
                    $(Self::$Law(law) => law.validate(),)*
                }
            }
        }
    };
}

laws! {
    without memory {
        Viscous, viscous, "viscous";
        Classic, classic, "classic";
        MajdSimaan, majd_simaan, "majd_simaan";
    }
    with memory {
        Coulomb, Coulomb<S>, CoulombState, coulomb, "coulomb";
        Dahl, Dahl<S>, DahlState<S>, dahl, "dahl";
        LuGre, LuGre<S>, LuGreState<S>, lugre, "lugre";
        Bristle, Bristle<S, BONDS>, BristleState<S, BONDS>, bristle, "bristle";
        HaywardArmstrong, HaywardArmstrong<S>, HaywardArmstrongState<S>, hayward_armstrong, "hayward_armstrong";
        ElastoPlastic, ElastoPlastic<S>, ElastoPlasticState<S>, elasto_plastic, "elasto_plastic";
        MaxwellSlip, MaxwellSlip<S>, MaxwellSlipState<S>, maxwell_slip, "maxwell_slip";
        Armstrong, Armstrong<S>, ArmstrongState<S>, armstrong, "armstrong";
    }
}

/// Which law. Saved presets hold the place of a variant: new ones stand at the end.
///
/// ```
/// use friction::LawKind;
/// assert_eq!(LawKind::from_id("majd_simaan"), Some(LawKind::MajdSimaan));
/// assert_eq!(LawKind::ALL.len(), friction::LAWS.len());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum LawKind {
    /// Modified Karnopp, [thesis, eq. 3.1].
    #[default]
    Karnopp,
    /// Modified Dahl, [thesis, eq. 3.2, 3.3].
    Dahl,
    /// Coulomb as a stopping force.
    Coulomb,
    /// LuGre.
    LuGre,
    /// Viscous friction alone.
    Viscous,
    /// Stick-slip by a steep line through rest.
    Classic,
    /// One continuous curve of speed.
    MajdSimaan,
    /// Bonds that snap and form again.
    Bristle,
    /// A function of displacement alone.
    HaywardArmstrong,
    /// LuGre with an elastic range.
    ElastoPlastic,
    /// Generalised Maxwell slip.
    MaxwellSlip,
    /// The seven-parameter model.
    Armstrong,
}

/// Ids in the order shown to a user, with commas. A message on a device has no memory to put it together.
macro_rules! law_kinds {
    ($($kind:ident $id:literal),*) => {
        impl LawKind {
            /// Every law, in the order shown to a user.
            pub const ALL: &'static [Self] = &[$(Self::$kind),*];
            /// Every id.
            pub const IDS: &'static str = law_kinds!(@ $($id),*);
            /// What a law is, for help.
            pub const WHAT: &'static str = concat!("friction law: ", law_kinds!(@ $($id),*));
        }
    };
    (@ $first:literal $(, $id:literal)*) => { concat!($first $(, ", ", $id)*) };
}

law_kinds! {
    Karnopp "karnopp", Dahl "dahl", Coulomb "coulomb", LuGre "lugre", ElastoPlastic "elasto_plastic",
    MaxwellSlip "maxwell_slip", HaywardArmstrong "hayward_armstrong", Armstrong "armstrong", MajdSimaan "majd_simaan",
    Classic "classic", Bristle "bristle", Viscous "viscous"
}

impl LawKind {
    /// The law with this id.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|law| law.id() == id)
    }

    /// Whether a body under a load below the static friction stays exactly at rest.
    #[must_use]
    pub const fn holds(self) -> bool {
        matches!(self, Self::Karnopp | Self::Coulomb)
    }
}
