//! Effects by name: `stribeck.force_p`.

use super::parameters::SetWhy;
use super::{Settings, Value};
use crate::number;
use friction::effects::{Effect, EffectKind};

/// Index of a parameter in the gains or in the shape of an effect.
pub(crate) enum Slot {
    Gain(usize),
    Shape(usize),
}

pub(crate) fn slot(kind: EffectKind, parameter: &str) -> Option<Slot> {
    let gain = kind.gains().iter().position(|p| p.name == parameter).map(Slot::Gain);
    gain.or_else(|| kind.shape().iter().position(|p| p.name == parameter).map(Slot::Shape))
}

/// Cycles that an effect adds to a control step on the NUCLEO-G474RE at worst, rounded up. `tests/elf/cycles.rs` measures
/// them; an effect that is not listed counts as the most expensive one.
#[must_use]
pub fn effect_cycles(kind: EffectKind) -> u32 {
    match kind {
        EffectKind::Spring => 80,
        EffectKind::Offset => 90,
        EffectKind::NonlinearSpring | EffectKind::HardStop | EffectKind::QuadraticDrag => 120,
        EffectKind::LoadDependentFriction => 130,
        EffectKind::PositionDependentFriction => 160,
        EffectKind::FrictionDrift | EffectKind::Presliding => 250,
        EffectKind::Gravity => 330,
        EffectKind::TorqueRipple => 370,
        EffectKind::PeriodicFriction => 370,
        EffectKind::Cogging => 400,
        EffectKind::RisingStaticFriction => 350,
        EffectKind::FrictionalLag => 560,
        EffectKind::Stribeck | EffectKind::SublinearViscous => 600,
        _ => 800,
    }
}

/// Cycles that the passivity controller adds to a control step on the NUCLEO-G474RE at worst, rounded up.
/// `tests/elf/cycles.rs` measures them.
pub const PASSIVITY_CYCLES: u32 = 150;

impl Settings {
    pub(super) fn get_effect(&self, name: &str) -> Option<Value> {
        let (id, parameter) = name.split_once('.')?;
        let kind = EffectKind::from_id(id)?;
        let effect = self.effects.iter().flatten().find(|effect| effect.kind == kind)?;
        let value = match slot(kind, parameter)? {
            Slot::Gain(at) => effect.gains.get(at),
            Slot::Shape(at) => effect.shape.get(at),
        };
        value.map(|x| Value::Number(*x))
    }

    pub(super) fn set_effect(&mut self, name: &str, value: &str) -> Result<(), SetWhy> {
        let Some((id, parameter)) = name.split_once('.') else {
            let kind = EffectKind::from_id(name).ok_or(SetWhy::UnknownParameter)?;
            if value != "off" {
                return Err(SetWhy::NotOneOf("off; set its parameters by EFFECT.PARAMETER"));
            }
            for place in &mut self.effects {
                if place.is_some_and(|effect| effect.kind == kind) {
                    *place = None;
                }
            }
            return Ok(());
        };
        let kind = EffectKind::from_id(id).ok_or(SetWhy::UnknownParameter)?;
        let slot =
            slot(kind, parameter).ok_or(SetWhy::UnknownOfEffect(kind.id(), kind.gains(), kind.shape()))?;
        let x = number::parse(value).ok_or(SetWhy::NotANumber)?;
        let held = self.effects.iter().position(|place| place.is_some_and(|effect| effect.kind == kind));
        let at = held.or_else(|| self.effects.iter().position(Option::is_none)).ok_or(SetWhy::EffectsFull)?;
        let place = self.effects.get_mut(at).ok_or(SetWhy::EffectsFull)?;
        let effect = place.get_or_insert_with(|| Effect::silent(kind));
        let value = match slot {
            Slot::Gain(at) => effect.gains.get_mut(at),
            Slot::Shape(at) => effect.shape.get_mut(at),
        };
        if let Some(value) = value {
            *value = x;
        }
        Ok(())
    }
}
