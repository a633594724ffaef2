//! The parameters of a preset, of which each law takes its own.

use crate::{
    Adhesion, Armstrong, Bristle, Classic, Coulomb, Dahl, ElastoPlastic, HaywardArmstrong, Karnopp, Law,
    LawKind, LuGre, MajdSimaan, MaxwellSlip, Scalar, Viscous,
};

macro_rules! surface {
    ($($(#[doc = $what:literal])* $field:ident $name:literal,)*) => {
        /// What a surface is by the names of a preset, for whichever law. Levels are magnitudes.
        ///
        /// ```
        /// use friction::{FrictionLaw, LawKind, Surface};
        /// let surface = Surface { dynamic_p: 3.0, dynamic_n: 3.0, static_p: 3.5, static_n: 3.5, ..Surface::default() };
        /// for kind in LawKind::ALL {
        ///     let law = surface.law(*kind);
        ///     assert!(law.validate().is_ok() && law.kind() == *kind);
        /// }
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct Surface<S> {
            $($(#[doc = $what])* pub $field: S,)*
            /// The way a contact yields.
            pub adhesion: Adhesion,
        }

        impl<S: Copy> Surface<S> {
            /// Every name of a number.
            pub const NAMES: &'static [&'static str] = &[$($name),*];

            /// The number with this name in a preset; `f_static`, `f_dynamic` and `damping` are those of positive motion.
            pub fn get(&self, name: &str) -> Option<S> {
                match directions(name).map_or(name, |[positive, _]| positive) {
                    $($name => Some(self.$field),)*
                    _ => None,
                }
            }

            /// The place of the number with this name.
            pub fn get_mut(&mut self, name: &str) -> Option<&mut S> {
                match name {
                    $($name => Some(&mut self.$field),)*
                    _ => None,
                }
            }
        }
    };
}

surface! {
    /// Static friction against positive motion, N.
    static_p "f_static_p",
    /// Static friction against negative motion, N.
    static_n "f_static_n",
    /// Dynamic friction against positive motion, N.
    dynamic_p "f_dynamic_p",
    /// Dynamic friction against negative motion, N.
    dynamic_n "f_dynamic_n",
    /// Viscous damping against positive motion, N·s/m.
    damping_p "damping_p",
    /// Viscous damping against negative motion, N·s/m.
    damping_n "damping_n",
    /// Speed treated as zero, m/s.
    dv "dv",
    /// Stiffness of the contact before it slides, N/m.
    sigma "sigma",
    /// Damping of the bristles, N·s/m.
    sigma_1 "sigma_1",
    /// Exponent of Dahl's law.
    exponent "exponent",
    /// Speed at which static friction has fallen to dynamic friction, m/s.
    stribeck_velocity "stribeck_velocity",
    /// Elastic range as a share of the dynamic friction.
    elastic "elastic",
    /// Rate at which a slipping element follows the level, N/s.
    attraction "attraction",
    /// Time constant of the frictional memory, s.
    memory "memory",
    /// Time at rest after which static friction has risen by half, s.
    dwell "dwell",
    /// Steepness of a continuous curve at rest.
    steepness "steepness",
}

impl<S: Scalar> Default for Surface<S> {
    /// Without friction, and such that every law is valid.
    fn default() -> Self {
        let (zero, lit) = (S::zero(), S::lit);
        Self {
            static_p: zero,
            static_n: zero,
            dynamic_p: zero,
            dynamic_n: zero,
            damping_p: zero,
            damping_n: zero,
            dv: lit(1e-3),
            sigma: lit(1e4),
            sigma_1: zero,
            exponent: S::one(),
            stribeck_velocity: lit(0.01),
            elastic: lit(0.7),
            attraction: lit(3e3),
            memory: zero,
            dwell: S::one(),
            steepness: lit(10.0),
            adhesion: Adhesion::default(),
        }
    }
}

/// Names that stand for both directions.
pub const BOTH_DIRECTIONS: [&str; 3] = ["f_static", "f_dynamic", "damping"];

/// The names of positive and negative motion for which a name of [`BOTH_DIRECTIONS`] stands.
///
/// ```
/// assert_eq!(friction::directions("damping"), Some(["damping_p", "damping_n"]));
/// assert_eq!(friction::directions("dv"), None);
/// ```
#[must_use]
pub fn directions(name: &str) -> Option<[&'static str; 2]> {
    match name {
        "f_static" => Some(["f_static_p", "f_static_n"]),
        "f_dynamic" => Some(["f_dynamic_p", "f_dynamic_n"]),
        "damping" => Some(["damping_p", "damping_n"]),
        _ => None,
    }
}

impl LawKind {
    /// Names of the parameters of a preset that the law takes. One for both directions has neither `_p` nor `_n`.
    #[must_use]
    pub const fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::Karnopp => {
                &["f_static_p", "f_static_n", "f_dynamic_p", "f_dynamic_n", "damping_p", "damping_n", "dv"]
            }
            Self::Coulomb => {
                &["f_static_p", "f_static_n", "f_dynamic_p", "f_dynamic_n", "damping_p", "damping_n"]
            }
            Self::Dahl => &["f_dynamic_p", "f_dynamic_n", "damping", "sigma"],
            Self::LuGre => &["f_static", "f_dynamic", "damping", "sigma", "sigma_1", "stribeck_velocity"],
            Self::Viscous => &["damping_p", "damping_n"],
            Self::Classic => &["f_static", "f_dynamic", "damping", "dv", "stribeck_velocity"],
            Self::MajdSimaan => &["f_static", "f_dynamic", "damping", "stribeck_velocity", "steepness"],
            Self::Bristle => &["f_dynamic", "damping", "sigma"],
            Self::HaywardArmstrong => &["f_static", "f_dynamic", "damping", "sigma", "adhesion"],
            Self::ElastoPlastic => {
                &["f_static", "f_dynamic", "damping", "sigma", "sigma_1", "stribeck_velocity", "elastic"]
            }
            Self::MaxwellSlip => {
                &["f_static", "f_dynamic", "damping", "sigma", "stribeck_velocity", "attraction"]
            }
            Self::Armstrong => {
                &["f_static", "f_dynamic", "damping", "sigma", "stribeck_velocity", "memory", "dwell"]
            }
        }
    }

    /// Whether the law takes this parameter, by itself or as one direction of a parameter for both.
    ///
    /// ```
    /// use friction::LawKind;
    /// assert!(LawKind::LuGre.takes("f_static") && LawKind::LuGre.takes("f_static_n"));
    /// assert!(LawKind::Karnopp.takes("f_static_n") && !LawKind::Karnopp.takes("f_static"));
    /// ```
    #[must_use]
    pub fn takes(self, parameter: &str) -> bool {
        let is =
            |own: &&str| *own == parameter || directions(own).is_some_and(|both| both.contains(&parameter));
        self.parameters().iter().any(is)
    }
}

impl<S: Scalar> Surface<S> {
    /// The surface as this law describes it. A law with one value for both directions takes that of positive motion.
    #[must_use]
    pub fn law(&self, kind: LawKind) -> Law<S> {
        let Self { dynamic_p: coulomb, static_p: stiction, damping_p: viscous, stribeck_velocity, .. } =
            *self;
        let lugre = LuGre {
            sigma_0: self.sigma,
            sigma_1: self.sigma_1,
            sigma_2: viscous,
            coulomb,
            stiction,
            stribeck_velocity,
        };
        match kind {
            LawKind::Karnopp => Law::Karnopp(Karnopp {
                c_p: coulomb,
                c_n: self.dynamic_n,
                b_p: viscous,
                b_n: self.damping_n,
                d_p: stiction,
                d_n: self.static_n,
                delta_v: self.dv,
            }),
            LawKind::Coulomb => Law::Coulomb(Coulomb {
                level_p: coulomb,
                level_n: self.dynamic_n,
                static_p: stiction,
                static_n: self.static_n,
                viscous_p: viscous,
                viscous_n: self.damping_n,
            }),
            LawKind::Dahl => Law::Dahl(Dahl {
                limit_p: coulomb,
                limit_n: self.dynamic_n,
                sigma: self.sigma,
                exponent: self.exponent,
                viscous,
            }),
            LawKind::LuGre => Law::LuGre(lugre),
            LawKind::Viscous => Law::Viscous(Viscous { damping_p: viscous, damping_n: self.damping_n }),
            LawKind::Classic => Law::Classic(Classic {
                stiction,
                dynamic: coulomb,
                viscous,
                knee: self.dv,
                fallen: stribeck_velocity.max(self.dv),
            }),
            LawKind::MajdSimaan => {
                let law = MajdSimaan {
                    viscous,
                    coulomb,
                    stribeck: S::zero(),
                    critical_velocity: stribeck_velocity,
                    steepness: self.steepness,
                };
                Law::MajdSimaan(law.with_stiction(stiction))
            }
            LawKind::Bristle => Law::Bristle(Bristle { stiffness: self.sigma, level: coulomb, viscous }),
            LawKind::HaywardArmstrong => Law::HaywardArmstrong(HaywardArmstrong {
                stiffness: self.sigma,
                dynamic: coulomb,
                stiction,
                viscous,
                adhesion: self.adhesion,
            }),
            LawKind::ElastoPlastic => Law::ElastoPlastic(ElastoPlastic::of(lugre, self.elastic)),
            LawKind::MaxwellSlip => Law::MaxwellSlip(MaxwellSlip {
                stiction,
                stribeck_velocity,
                attraction: self.attraction,
                viscous,
                ..MaxwellSlip::of_stiffness(coulomb, self.sigma)
            }),
            LawKind::Armstrong => Law::Armstrong(Armstrong {
                coulomb,
                viscous,
                stribeck: stiction - coulomb,
                stiffness: self.sigma,
                stribeck_velocity,
                memory: self.memory,
                dwell: self.dwell,
            }),
        }
    }

    /// The surface of which this is the law. What the law does not take is that of [`Surface::default`].
    ///
    /// ```
    /// use friction::{LawKind, Surface};
    /// let law = Surface { dynamic_p: 3.0, static_p: 3.5, ..Surface::default() }.law(LawKind::LuGre);
    /// assert_eq!(Surface::of(&law).get("f_static"), Some(3.5));
    /// ```
    #[must_use]
    pub fn of(law: &Law<S>) -> Self {
        let own = Self::default();
        let even = |stiction, level, viscous| Self {
            static_p: stiction,
            static_n: stiction,
            dynamic_p: level,
            dynamic_n: level,
            damping_p: viscous,
            damping_n: viscous,
            ..own
        };
        match *law {
            Law::Karnopp(k) => Self {
                static_p: k.d_p,
                static_n: k.d_n,
                dynamic_p: k.c_p,
                dynamic_n: k.c_n,
                damping_p: k.b_p,
                damping_n: k.b_n,
                dv: k.delta_v,
                ..own
            },
            Law::Coulomb(c) => Self {
                static_p: c.static_p,
                static_n: c.static_n,
                dynamic_p: c.level_p,
                dynamic_n: c.level_n,
                damping_p: c.viscous_p,
                damping_n: c.viscous_n,
                ..own
            },
            Law::Dahl(d) => Self {
                static_n: d.limit_n,
                dynamic_n: d.limit_n,
                sigma: d.sigma,
                exponent: d.exponent,
                ..even(d.limit_p, d.limit_p, d.viscous)
            },
            Law::LuGre(l) => of_lugre(l, even(l.stiction, l.coulomb, l.sigma_2)),
            Law::Viscous(v) => Self { damping_p: v.damping_p, damping_n: v.damping_n, ..own },
            Law::Classic(c) => {
                Self { dv: c.knee, stribeck_velocity: c.fallen, ..even(c.stiction, c.dynamic, c.viscous) }
            }
            Law::MajdSimaan(m) => Self {
                stribeck_velocity: m.critical_velocity,
                steepness: m.steepness,
                ..even(m.stiction(), m.coulomb, m.viscous)
            },
            Law::Bristle(b) => Self { sigma: b.stiffness, ..even(b.level, b.level, b.viscous) },
            Law::HaywardArmstrong(h) => {
                Self { sigma: h.stiffness, adhesion: h.adhesion, ..even(h.stiction, h.dynamic, h.viscous) }
            }
            Law::ElastoPlastic(e) => {
                let levels = Self { elastic: e.elastic, ..even(e.stiction, e.coulomb, e.sigma_2) };
                of_lugre(e.bristles(), levels)
            }
            Law::MaxwellSlip(m) => Self {
                sigma: m.initial_stiffness(),
                stribeck_velocity: m.stribeck_velocity,
                attraction: m.attraction,
                ..even(m.stiction, m.coulomb, m.viscous)
            },
            Law::Armstrong(a) => Self {
                sigma: a.stiffness,
                stribeck_velocity: a.stribeck_velocity,
                memory: a.memory,
                dwell: a.dwell,
                ..even(a.coulomb + a.stribeck, a.coulomb, a.viscous)
            },
        }
    }
}

fn of_lugre<S>(bristles: LuGre<S>, levels: Surface<S>) -> Surface<S> {
    let LuGre { sigma_0: sigma, sigma_1, stribeck_velocity, .. } = bristles;
    Surface { sigma, sigma_1, stribeck_velocity, ..levels }
}
