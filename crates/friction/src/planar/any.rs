//! A law in the plane chosen at run time.

use super::{
    Coulomb, CoulombState, Dahl, DahlState, ElastoPlastic, ElastoPlasticState, FrictionLaw, Grain, Karnopp,
    LuGre, LuGreState, Motion, Vector,
};
use crate::{Invalid, Scalar};
use serde::{Deserialize, Serialize};

macro_rules! laws {
    ($($law:ident, $state:ty, $id:literal;)*) => {
        /// A law in the plane chosen at run time.
        ///
        /// ```
        /// use friction::planar::{Coulomb, FrictionLaw, Grain, Law, LawState, Motion, Vector};
        /// let law = Law::Coulomb(Coulomb { level: 2.0, stiction: 2.0, viscous: 0.0, grain: Grain::default() });
        /// let motion = Motion { velocity: Vector { x: 0.0, y: -0.1 }, ..Motion::default() };
        /// assert_eq!(law.step(&mut LawState::default(), &motion), Vector { x: 0.0, y: -2.0 });
        /// assert_eq!(law.id(), "coulomb");
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        pub enum Law<S> {
            $(#[doc = concat!("See [`", stringify!($law), "`].")]
            #[serde(rename = $id)]
            $law($law<S>),)*
        }

        /// State of a [`Law`]. A law given the state of another law starts from a fresh contact.
        ///
        /// ```
        /// assert_eq!(friction::planar::LawState::<f32>::default(), friction::planar::LawState::Fresh);
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub enum LawState<S> {
            /// No memory: the start of every law.
            #[default]
            Fresh,
            $(#[doc = concat!("State of [`", stringify!($law), "`].")]
            $law($state),)*
        }

        impl<S> Law<S> {
            /// Every id, in the order shown to a user.
            pub const IDS: [&'static str; 5] = [$($id),*];

            /// Id of the law, as a user types it.
            pub fn id(&self) -> &'static str {
                match self {
                    $(Self::$law(_) => $id,)*
                }
            }

            /// The grain of the surface.
            ///
            /// ```
            /// use friction::planar::{Grain, Karnopp, Law};
            /// let grain = Grain::at(0.0, 2.0);
            /// let law = Law::Karnopp(Karnopp { c: 1.0, b: 0.0, d: 1.0, delta_v: 1e-3, grain });
            /// assert_eq!(law.grain().across, 2.0);
            /// ```
            pub fn grain(&self) -> &Grain<S> {
                match self {
                    $(Self::$law(law) => &law.grain,)*
                }
            }
        }

        impl<S: Scalar> FrictionLaw<S> for Law<S> {
            type State = LawState<S>;

            fn step(&self, state: &mut LawState<S>, motion: &Motion<S>) -> Vector<S> {
                match self {
                    $(Self::$law(law) => {
                        let mut own = if let LawState::$law(own) = *state { own } else { Default::default() };
                        let force = law.step(&mut own, motion);
                        *state = LawState::$law(own);
                        force
                    })*
                }
            }

            fn validate(&self) -> Result<(), Invalid> {
                match self {
                    $(Self::$law(law) => law.validate(),)*
                }
            }
        }
    };
}

laws! {
    Karnopp, (), "karnopp";
    Dahl, DahlState<S>, "dahl";
    Coulomb, CoulombState, "coulomb";
    LuGre, LuGreState<S>, "lugre";
    ElastoPlastic, ElastoPlasticState<S>, "elasto_plastic";
}
