//! A law chosen at run time: what a preset names.

use crate::coulomb::CoulombState;
use crate::dahl::DahlState;
use crate::lugre::LuGreState;
use crate::{Coulomb, Dahl, FrictionLaw, Invalid, Karnopp, LuGre, Motion, Scalar};
use serde::{Deserialize, Serialize};

/// One of the complete laws.
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

/// What a [`Law`] remembers. A law that meets the memory of another kind starts from a fresh contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LawState<S> {
    /// Nothing: Karnopp has no memory, and every law starts here.
    #[default]
    Fresh,
    /// Memory of [`Dahl`].
    Dahl(DahlState<S>),
    /// Memory of [`Coulomb`].
    Coulomb(CoulombState),
    /// Memory of [`LuGre`].
    LuGre(LuGreState<S>),
}

impl<S> Law<S> {
    /// Every id, in the order they are listed to a user.
    pub const IDS: [&'static str; 4] = ["karnopp", "dahl", "coulomb", "lugre"];

    /// The name a user types.
    pub fn id(&self) -> &'static str {
        match self {
            Self::Karnopp(_) => "karnopp",
            Self::Dahl(_) => "dahl",
            Self::Coulomb(_) => "coulomb",
            Self::LuGre(_) => "lugre",
        }
    }
}

/// Steps a law with its own part of the memory. One function a law: together, each would save the registers that any of
/// them needs, a twentieth of a control step.
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

    // Karnopp's law, which every built-in preset has, in line: beside the others it would save their registers
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
