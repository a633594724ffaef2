//! An effect as a contributor adds it: this file, and one line of the catalogue. Built for the tests only.

use super::signature::{MAX_GAINS, MAX_MEMORY, MAX_SHAPE, Signature};
use super::{About, BY_DIRECTION, Describe, Parameter, Quantity, Scale};
use crate::{Dimension, Motion, Scalar};

/// Friction that grows with the logarithm of the speed.
///
/// F = s·rise·ln(1 + |v|/v_1), s = sgn v; by direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Toy;

impl Describe for Toy {
    const ABOUT: About = About {
        id: "toy",
        says: "Friction grows a little slower with every doubling of the speed.",
        equation: "s*rise*ln(1 + |v|/v_1)",
        shows: "odd in v, over decades of speed",
        confused_with: "sublinear_viscous",
        told_apart_by: "constant speeds over four decades",
        gains: &[
            Parameter::gain("rise_p", Dimension::FORCE, (0.0, 1e6), "friction gained per factor e of speed, positive motion"),
            Parameter::gain("rise_n", Dimension::FORCE, (0.0, 1e6), "friction gained per factor e of speed, negative motion"),
        ],
        groups: BY_DIRECTION,
        shape: &[Parameter::shape("v_1", Scale::Speed, (1e-6, 1e2), "speed from which it grows")],
        reads: &[Quantity::Velocity],
        opposes_motion: true,
        ..About::EFFECT
    };
}

impl Signature for Toy {
    fn unit<S: Scalar>(
        &[v_1, _]: &[S; MAX_SHAPE],
        _memory: &mut [S; MAX_MEMORY],
        motion: &Motion<S>,
    ) -> [S; MAX_GAINS] {
        let v = motion.velocity;
        super::signature::by_direction(v, v.sgn() * (S::one() + v.abs() / v_1).ln())
    }
}

#[cfg(test)]
mod tests {
    use crate::Geometry::Rotary;
    use crate::effects::{CATALOGUE, Effect, EffectKind, EffectState, about};
    use crate::{Dimension, Invalid, Motion};
    use std::string::ToString;
    use std::vec::Vec;

    #[test]
    fn a_line_of_the_catalogue_lists_it() {
        assert_eq!(EffectKind::from_id("toy"), Some(EffectKind::Toy));
        assert!(EffectKind::ALL.contains(&EffectKind::Toy) && CATALOGUE.iter().any(|a| a.id == "toy"));
        assert_eq!(serde_json::to_string(&EffectKind::Toy).expect("a name"), "\"toy\"");
    }

    #[test]
    fn its_file_describes_it() {
        let toy = about("toy").expect("listed");
        let units: Vec<_> = toy.parameters().map(|p| (p.name, p.unit(Rotary).to_string())).collect();
        let expected = [("rise_p", "N·m"), ("rise_n", "N·m"), ("v_1", "rad/s")];
        assert_eq!(units, expected.map(|(name, unit)| (name, unit.to_string())));
        assert_eq!(toy.shape[0].dimension, Dimension::VELOCITY);
        assert_eq!(toy.groups.len(), 2);
        assert!(EffectKind::Toy.opposes_motion());
    }

    #[test]
    fn it_is_validated_and_stepped() {
        let mut toy = Effect::silent(EffectKind::Toy);
        for (name, value) in [("rise_p", 0.5), ("rise_n", 0.5), ("v_1", 0.01)] {
            *toy.get_mut(name).expect("a parameter") = value;
        }
        assert_eq!(toy.validate(), Ok(()));
        let back = Motion { velocity: -0.01, ..Motion::default() };
        let force: f64 = toy.step(&mut EffectState::default(), &back);
        assert!((force + 0.5 * core::f64::consts::LN_2).abs() < 1e-12);
        *toy.get_mut("v_1").expect("a parameter") = 0.0;
        assert_eq!(toy.validate(), Err(Invalid { parameter: "v_1", value: 0.0, min: 1e-6, max: 1e2 }));
    }
}
