//! Names that tell several effects of one kind apart.

use super::{Effect, EffectKind};
use core::fmt;

/// The name of an effect: its id, with a number from the second of its kind on, as in `cogging_2`. Only kinds with
/// [`About::several_by`](super::About::several_by) have numbers.
///
/// ```
/// use friction::effects::{EffectKind, EffectName};
///
/// let second = EffectName { kind: EffectKind::Cogging, index: 1 };
/// assert_eq!(second.to_string(), "cogging_2");
/// assert_eq!(EffectName::parse("cogging_2"), Some(second));
/// assert_eq!(EffectName::parse("spring_2"), None); // two springs are one
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct EffectName {
    /// Which effect.
    pub kind: EffectKind,
    /// Number of effects of the same kind before it.
    pub index: usize,
}

impl EffectName {
    /// The effect of this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        if let Some(kind) = EffectKind::from_id(name) {
            return Some(Self { kind, index: 0 });
        }
        let (id, number) = name.rsplit_once('_')?;
        let kind = EffectKind::from_id(id).filter(|kind| kind.may_repeat())?;
        match number.as_bytes() {
            [digit @ b'2'..=b'9'] => Some(Self { kind, index: usize::from(digit - b'1') }),
            _ => None,
        }
    }

    /// Pairs each effect with its name.
    pub fn of<'a, S: 'a>(
        effects: impl Iterator<Item = &'a Effect<S>>,
    ) -> impl Iterator<Item = (Self, &'a Effect<S>)> {
        let mut seen = [0; EffectKind::ALL.len()];
        effects.map(move |effect| {
            let kind = effect.kind;
            let index = seen.get_mut(kind as usize).map_or(0, |before| {
                *before += 1;
                *before - 1
            });
            (Self { kind, index }, effect)
        })
    }
}

impl fmt::Display for EffectName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.kind.id())?;
        if self.index > 0 { write!(f, "_{}", self.index + 1) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;
    use std::vec::Vec;

    #[test]
    fn every_effect_is_found_by_its_name() {
        for &kind in EffectKind::ALL {
            let effects = [Effect::<f64>::silent(kind), Effect::silent(kind)];
            let names: Vec<EffectName> = EffectName::of(effects.iter()).map(|(name, _)| name).collect();
            assert_eq!(EffectName::parse(&names[0].to_string()), Some(names[0]));
            let second = EffectName::parse(&names[1].to_string());
            assert_eq!(second, kind.may_repeat().then_some(names[1]), "{}", names[1]);
        }
        for none in ["", "_2", "cogging_", "cogging_1", "cogging_10", "cogging_x", "cogging_2_2"] {
            assert_eq!(EffectName::parse(none), None, "{none}");
        }
    }
}
