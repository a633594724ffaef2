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

impl<S: Scalar> Law<S> {
    #[inline(never)]
    fn step_with_memory(&self, state: &mut LawState<S>, motion: &Motion<S>) -> S {
        match self {
            Self::Karnopp(law) => law.step(&mut (), motion),
            Self::Dahl(law) => {
                let mut own = if let LawState::Dahl(own) = *state { own } else { DahlState::default() };
                let force = law.step(&mut own, motion);
                *state = LawState::Dahl(own);
                force
            }
            Self::Coulomb(law) => {
                let mut own = if let LawState::Coulomb(own) = *state { own } else { CoulombState::default() };
                let force = law.step(&mut own, motion);
                *state = LawState::Coulomb(own);
                force
            }
            Self::LuGre(law) => {
                let mut own = if let LawState::LuGre(own) = *state { own } else { LuGreState::default() };
                let force = law.step(&mut own, motion);
                *state = LawState::LuGre(own);
                force
            }
        }
    }
}

impl<S: Scalar> FrictionLaw<S> for Law<S> {
    type State = LawState<S>;

    // Karnopp's law, which every built-in preset has, in line: beside the others it would save their registers
    #[inline(always)]
    fn step(&self, state: &mut LawState<S>, motion: &Motion<S>) -> S {
        if let Self::Karnopp(law) = self {
            *state = LawState::Fresh;
            return law.step(&mut (), motion);
        }
        self.step_with_memory(state, motion)
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
