//! A law chosen at run time, as a preset names it.

use crate::coulomb::CoulombState;
use crate::dahl::DahlState;
use crate::lugre::LuGreState;
use crate::{Coulomb, Dahl, FrictionLaw, Invalid, Karnopp, LuGre, Motion, Scalar};
use serde::{Deserialize, Serialize};

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
#[serde(rename_all = "lowercase")]
pub enum Law<S> {
    /// See [`Karnopp`].
    Karnopp(Karnopp<S>),
    /// See [`Dahl`].
    Dahl(Dahl<S>),
    /// See [`Coulomb`].
    Coulomb(Coulomb<S>),
    /// See [`LuGre`].
    LuGre(LuGre<S>),
}

/// State of a [`Law`]. A law given the state of another law starts from a fresh contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LawState<S> {
    /// No memory: the state of Karnopp, and the start of every law.
    #[default]
    Fresh,
    /// State of [`Dahl`].
    Dahl(DahlState<S>),
    /// State of [`Coulomb`].
    Coulomb(CoulombState),
    /// State of [`LuGre`].
    LuGre(LuGreState<S>),
}

impl<S> Law<S> {
    /// Every id, in the order shown to a user.
    pub const IDS: [&'static str; 4] = ["karnopp", "dahl", "coulomb", "lugre"];

    /// Id of the law, as a user types it.
    pub fn id(&self) -> &'static str {
        match self {
            Self::Karnopp(_) => "karnopp",
            Self::Dahl(_) => "dahl",
            Self::Coulomb(_) => "coulomb",
            Self::LuGre(_) => "lugre",
        }
    }
}

/// Steps a law with its own state. Each law has a function of its own: in a common one every law would save the registers
/// that any of them needs, which costs a twentieth of a control step.
macro_rules! with_memory {
    ($($name:ident, $law:ident;)*) => {
        impl<S: Scalar> LawState<S> {
            $(#[inline(never)]
            fn $name(&mut self, law: &$law<S>, motion: &Motion<S>) -> S {
                let mut own = if let Self::$law(own) = *self { own } else { Default::default() };
                let force = law.step(&mut own, motion);
                *self = Self::$law(own);
                force
            })*
        }
    };
}

with_memory! {
    dahl, Dahl;
    coulomb, Coulomb;
    lugre, LuGre;
}

impl<S: Scalar> FrictionLaw<S> for Law<S> {
    type State = LawState<S>;

    // inline: every built-in preset uses Karnopp, and in a common function it would save the registers of the others
    #[inline(always)]
    fn step(&self, state: &mut LawState<S>, motion: &Motion<S>) -> S {
        match self {
            Self::Karnopp(law) => {
                *state = LawState::Fresh;
                law.step(&mut (), motion)
            }
            Self::Dahl(law) => state.dahl(law, motion),
            Self::Coulomb(law) => state.coulomb(law, motion),
            Self::LuGre(law) => state.lugre(law, motion),
        }
    }

    fn validate(&self) -> Result<(), Invalid> {
        match self {
            Self::Karnopp(law) => law.validate(),
            Self::Dahl(law) => law.validate(),
            Self::Coulomb(law) => law.validate(),
            Self::LuGre(law) => law.validate(),
        }
    }
}
