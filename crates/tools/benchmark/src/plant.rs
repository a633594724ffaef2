//! A sliding body in any scalar: what a free run integrates.

use crate::place::{Place, Way};
use friction::effects::{Effect, EffectState, SeriesEffect, SeriesKind};
use friction::{Coulomb, CoulombState, FrictionLaw, Law, Motion, Scalar};
use identify::{Model, Nuisances};

/// Smallest speed with a direction, m/s: asks a law for its level beside rest.
const CREEP: f64 = 1e-12;

/// Mass, Coulomb and viscous friction, and effects without memory. Made of parameters by [`Plant::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct Plant<S> {
    /// kg.
    pub mass: S,
    law: Coulomb<S>,
    effects: Vec<Effect<S>>,
    /// Time by which the force channel is behind the position, s.
    pub delay: S,
    /// Extra gain of the force channel for positive force.
    pub force_gain: S,
}

impl<S: Scalar> Plant<S> {
    /// A plant with these parameters, one value for each place; what is not named adds nothing.
    ///
    /// ```
    /// use benchmark::{Place, Plant, Way};
    /// let plant = Plant::new(&[Place::Mass, Place::Level(Way::Both)], &[2.0, 0.5]);
    /// assert_eq!(plant.resistance(0.0, -0.1), -0.5); // N, positive against positive motion
    /// ```
    #[must_use]
    pub fn new(places: &[Place], values: &[S]) -> Self {
        let zero = S::zero();
        let mut plant = Self {
            mass: S::one(),
            law: Coulomb {
                level_p: zero,
                level_n: zero,
                static_p: zero,
                static_n: zero,
                viscous_p: zero,
                viscous_n: zero,
            },
            effects: Vec::new(),
            delay: zero,
            force_gain: zero,
        };
        for (place, value) in places.iter().zip(values) {
            plant.set(*place, *value);
        }
        plant
    }

    fn set(&mut self, place: Place, value: S) {
        let by = |way, p: &mut S, n: &mut S| {
            if way != Way::Backward {
                *p = value;
            }
            if way != Way::Forward {
                *n = value;
            }
        };
        match place {
            Place::Mass => self.mass = value,
            Place::Level(way) => by(way, &mut self.law.level_p, &mut self.law.level_n),
            Place::Viscous(way) => by(way, &mut self.law.viscous_p, &mut self.law.viscous_n),
            Place::Delay => self.delay = value,
            Place::ForceGain => self.force_gain = value,
            Place::Gain(kind, index) => {
                let at = self.effects.iter().position(|e| e.kind == kind).unwrap_or_else(|| {
                    self.effects.push(Effect::silent(kind));
                    self.effects.len() - 1
                });
                self.effects[at].gains[index] = value;
            }
        }
    }

    /// Force against the motion at `position` m and `velocity` m/s, N; at rest, that of the effects.
    #[inline]
    pub fn resistance(&self, position: S, velocity: S) -> S {
        let motion = Motion { position, velocity, ..Motion::default() };
        let law = self.law.step(&mut CoulombState::default(), &motion);
        self.effects.iter().fold(law, |sum, e| sum + e.step(&mut EffectState::default(), &motion))
    }

    /// Direction in which `force` moves a body at rest at `position`: 1, −1, or 0 where friction holds it.
    pub fn breaks_away(&self, position: S, force: S) -> S {
        let creep = S::lit(CREEP);
        if force > self.resistance(position, creep) {
            S::one()
        } else if force < self.resistance(position, -creep) {
            -S::one()
        } else {
            S::zero()
        }
    }

    /// Whether a body can be held at rest: a free run then looks for the moments when it stops.
    pub fn has_dry_friction(&self) -> bool {
        self.law.level_p.re() != 0.0 || self.law.level_n.re() != 0.0
    }

    /// Force that acts, from the one that is recorded.
    #[inline]
    pub fn acting(&self, recorded: S) -> S {
        if recorded > S::zero() { recorded / (S::one() + self.force_gain) } else { recorded }
    }
}

impl Plant<f64> {
    /// The same plant in another scalar, its parameters constants.
    #[must_use]
    pub fn lifted<S: Scalar>(&self) -> Plant<S> {
        let Coulomb { level_p, level_n, static_p, static_n, viscous_p, viscous_n } = self.law;
        let effect =
            |e: &Effect<f64>| Effect { kind: e.kind, gains: e.gains.map(S::lit), shape: e.shape.map(S::lit) };
        Plant {
            mass: S::lit(self.mass),
            law: Coulomb {
                level_p: S::lit(level_p),
                level_n: S::lit(level_n),
                static_p: S::lit(static_p),
                static_n: S::lit(static_n),
                viscous_p: S::lit(viscous_p),
                viscous_n: S::lit(viscous_n),
            },
            effects: self.effects.iter().map(effect).collect(),
            delay: S::lit(self.delay),
            force_gain: S::lit(self.force_gain),
        }
    }
}

impl From<&Plant<f64>> for Model {
    /// As `predict` and a preset read it. Static friction is the sliding level.
    fn from(plant: &Plant<f64>) -> Self {
        let law = Coulomb { static_p: plant.law.level_p, static_n: plant.law.level_n, ..plant.law };
        let asymmetry = SeriesEffect {
            kind: SeriesKind::ForceGainAsymmetry,
            gains: [plant.force_gain, 0.0, 0.0, 0.0],
            shape: [0.0; 2],
        };
        Self {
            name: "benchmark".into(),
            mass: plant.mass,
            law: Law::Coulomb(law),
            effects: plant.effects.clone(),
            nuisances: Nuisances {
                delay_s: plant.delay,
                sensors: if plant.force_gain == 0.0 { Vec::new() } else { vec![asymmetry] },
                ..Nuisances::default()
            },
            ..Self::default()
        }
    }
}
