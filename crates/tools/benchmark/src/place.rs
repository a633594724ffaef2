//! Where a parameter sits in a model.

use friction::effects::EffectKind;
use friction::{Dimension, Geometry, Unit};

/// Direction of motion that a parameter of the law belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Positive motion.
    Forward,
    /// Negative motion.
    Backward,
    /// Both alike.
    Both,
}

/// Where a parameter sits in a [`crate::Plant`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Moving mass.
    Mass,
    /// Coulomb level.
    Level(Way),
    /// Viscous coefficient.
    Viscous(Way),
    /// A gain of an effect of the catalogue, by its index. The effect must have no memory and no shape.
    Gain(EffectKind, usize),
    /// Time by which the force channel is behind the position.
    Delay,
    /// Extra gain of the force channel for positive force (`force_gain_asymmetry`).
    ForceGain,
}

impl Place {
    /// Name, as in an identification or in the catalogue.
    ///
    /// ```
    /// use benchmark::Place;
    /// use friction::effects::EffectKind;
    /// assert_eq!(Place::Gain(EffectKind::NonlinearSpring, 0).name(), "nonlinear_spring.cubic");
    /// assert_eq!(Place::Gain(EffectKind::NonlinearSpring, 0).unit(), "N/m³");
    /// ```
    #[must_use]
    pub fn name(self) -> String {
        let by = |name: &str, way| match way {
            Way::Forward => format!("{name}_p"),
            Way::Backward => format!("{name}_n"),
            Way::Both => name.to_owned(),
        };
        match self {
            Self::Mass => "mass".into(),
            Self::Level(way) => by("coulomb", way),
            Self::Viscous(way) => by("viscous", way),
            Self::Gain(kind, index) => format!("{}.{}", kind.id(), kind.gains()[index].name),
            Self::Delay => "time_skew.tau".into(),
            Self::ForceGain => "force_gain_asymmetry.gain".into(),
        }
    }

    /// SI unit on a slide; empty for a pure number.
    #[must_use]
    pub fn unit(self) -> String {
        let dimension = match self {
            Self::Mass => Dimension::MASS,
            Self::Level(_) => Dimension::FORCE,
            Self::Viscous(_) => Dimension::FORCE.per(Dimension::VELOCITY),
            Self::Gain(kind, index) => kind.gains()[index].dimension,
            Self::Delay => Dimension::TIME,
            Self::ForceGain => Dimension::NUMBER,
        };
        let unit: Unit = dimension.unit(Geometry::Linear);
        unit.to_string()
    }
}
