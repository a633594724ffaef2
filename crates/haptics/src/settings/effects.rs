//! Effects by name: `stribeck.force_p`.

use super::parameters::SetWhy;
use super::{Settings, Value};
use crate::number;
use friction::LawKind;
use friction::effects::{Effect, EffectKind, EffectName};

/// Index of a parameter in the gains or in the shape of an effect.
enum Slot {
    Gain(usize),
    Shape(usize),
}

fn slot(kind: EffectKind, parameter: &str) -> Option<Slot> {
    let gain = kind.gains().iter().position(|p| p.name == parameter).map(Slot::Gain);
    gain.or_else(|| kind.shape().iter().position(|p| p.name == parameter).map(Slot::Shape))
}

/// Cycles that an effect adds to a control step on the NUCLEO-G474RE at worst, rounded up. `tests/elf/cycles.rs` measures
/// them; an effect that is not listed counts as the most expensive one.
#[must_use]
pub fn effect_cycles(kind: EffectKind) -> u32 {
    match kind {
        EffectKind::Spring => 90,
        EffectKind::Offset => 100,
        EffectKind::NonlinearSpring | EffectKind::HardStop | EffectKind::QuadraticDrag => 120,
        EffectKind::LoadDependentFriction => 130,
        EffectKind::PositionDependentFriction => 160,
        EffectKind::FrictionDrift | EffectKind::Presliding => 270,
        EffectKind::Gravity => 340,
        EffectKind::TorqueRipple => 390,
        EffectKind::PeriodicFriction => 390,
        EffectKind::Cogging => 420,
        EffectKind::RisingStaticFriction => 390,
        EffectKind::FrictionalLag => 560,
        EffectKind::Stribeck | EffectKind::SublinearViscous => 620,
        _ => 860,
    }
}

/// Cycles that a control step on the NUCLEO-G474RE takes more when it has any effect, beside those of the effect.
pub const EFFECTS_CYCLES: u32 = 150;

/// Cycles of a control step on the NUCLEO-G474RE at worst, rounded up, that a law takes beyond a tenth of the period at 10 kHz, in
/// which the others stay. `tests/elf/cycles.rs` measures them.
#[must_use]
pub fn law_cycles(kind: LawKind) -> u32 {
    match kind {
        LawKind::MaxwellSlip => 350,
        LawKind::ElastoPlastic => 1_040,
        LawKind::Bristle => 350,
        _ => 0,
    }
}

/// Cycles that the passivity controller adds to a control step on the NUCLEO-G474RE at worst, rounded up.
/// `tests/elf/cycles.rs` measures them.
pub const PASSIVITY_CYCLES: u32 = 150;

/// Places of the effects of a kind, in the order of their names.
fn places(effects: &[Option<Effect<f32>>], kind: EffectKind) -> impl DoubleEndedIterator<Item = usize> {
    effects.iter().enumerate().filter(move |(_, e)| e.is_some_and(|e| e.kind == kind)).map(|(at, _)| at)
}

/// The effect of this name.
pub(crate) fn named(effects: &[Option<Effect<f32>>], name: EffectName) -> Option<&Effect<f32>> {
    let at = places(effects, name.kind).nth(name.index)?;
    effects.get(at)?.as_ref()
}

/// The parameter of an effect, by name. A missing effect is added after the others of its kind.
pub(crate) fn parameter_of<'a>(
    effects: &'a mut [Option<Effect<f32>>],
    name: EffectName,
    parameter: &str,
    full: SetWhy,
) -> Result<&'a mut f32, SetWhy> {
    let kind = name.kind;
    let slot = slot(kind, parameter).ok_or(SetWhy::UnknownOfEffect(name, kind.gains(), kind.shape()))?;
    let held = places(effects, kind).nth(name.index);
    let at = held.map_or_else(|| room(effects, name, full), Ok)?;
    let effect = effects.get_mut(at).ok_or(full)?.get_or_insert_with(|| Effect::silent(kind));
    let place = match slot {
        Slot::Gain(at) => effect.gains.get_mut(at),
        Slot::Shape(at) => effect.shape.get_mut(at),
    };
    place.ok_or(full)
}

/// A free place after the effects of this kind, for the next of them.
fn room(effects: &mut [Option<Effect<f32>>], name: EffectName, full: SetWhy) -> Result<usize, SetWhy> {
    let kind = name.kind;
    let count = places(effects, kind).count();
    if name.index > count {
        return Err(SetWhy::NextIs(EffectName { kind, index: count }));
    }
    let behind = places(effects, kind).next_back().map_or(0, |last| last + 1);
    let free = |from: usize| Some(from + effects.get(from..)?.iter().position(Option::is_none)?);
    if let Some(at) = free(behind) {
        return Ok(at);
    }
    let at = free(0).ok_or(full)?;
    effects.get_mut(at..behind).ok_or(full)?.rotate_left(1);
    Ok(behind - 1)
}

impl Settings {
    pub(super) fn get_effect(&self, name: &str) -> Option<Value> {
        let (effect, parameter) = name.split_once('.')?;
        named(&self.effects, EffectName::parse(effect)?)?.get(parameter).map(Value::Number)
    }

    pub(super) fn set_effect(&mut self, name: &str, value: &str) -> Result<(), SetWhy> {
        let Some((effect, parameter)) = name.split_once('.') else {
            let name = EffectName::parse(name).ok_or(SetWhy::UnknownParameter)?;
            if value != "off" {
                return Err(SetWhy::NotOneOf("off; set its parameters by EFFECT.PARAMETER"));
            }
            // those after it go, too: they would move up to its name
            let of_kind = self.effects.iter_mut().filter(|e| e.is_some_and(|e| e.kind == name.kind));
            of_kind.skip(name.index).for_each(|place| *place = None);
            return Ok(());
        };
        let effect = EffectName::parse(effect).ok_or(SetWhy::UnknownParameter)?;
        let mut next = self.effects;
        let place = parameter_of(&mut next, effect, parameter, SetWhy::EffectsFull)?;
        *place = number::parse(value).ok_or(SetWhy::NotANumber)?;
        self.effects = next;
        Ok(())
    }
}
