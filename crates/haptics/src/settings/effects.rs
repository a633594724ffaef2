//! Effects by name: `stribeck.force_p`.

use super::parameters::SetWhy;
use super::{Settings, Value};
use crate::number;
use friction::LawKind;
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
