//! A complete law plus effects: the block of a rig in which an effect is concealed.

use friction::effects::{Effect, EffectState};
use friction::{FreeForm, FreeFormState, FrictionLaw, Invalid, Motion};

/// Largest number of effects on one block.
pub const MAX_EFFECTS: usize = 4;
/// Largest number of free forms on one block.
pub const MAX_CURVES: usize = 3;

/// A base law plus up to [`MAX_EFFECTS`] effects of the catalogue. The sum is a law itself.
///
/// The effects act first, and the base law balances or stops the remaining load. Additional friction therefore also adds to
/// stiction, and stiction holds a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layered<L> {
    /// The complete law underneath.
    pub base: L,
    /// Mass of the block, kg. If given, effects that scale with the load (`load_dependent_friction`, `torque_ripple`) see
    /// the force *on the block*, which a load cell between device and block measures and a recording calls the applied
    /// force. With `None` they see the force on the whole moving mass.
    pub block_mass: Option<f64>,
    effects: [Option<Effect<f64>>; MAX_EFFECTS],
    curves: [Option<FreeForm<f64>>; MAX_CURVES],
}

/// State of a [`Layered`] law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LayeredState<S> {
    base: S,
    effects: [EffectState<f64>; MAX_EFFECTS],
    curves: [FreeFormState<f64>; MAX_CURVES],
    /// Friction of the previous step, N.
    force: f64,
}

/// Puts `item` into the first empty slot.
fn fill<T>(parameter: &'static str, slots: &mut [Option<T>], item: T) -> Result<(), Invalid> {
    let max = slots.len() as f64;
    let slot = slots.iter_mut().find(|slot| slot.is_none());
    *slot.ok_or(Invalid { parameter, value: max + 1.0, min: 0.0, max })? = Some(item);
    Ok(())
}

impl<L> Layered<L> {
    /// A law without effects.
    pub const fn new(base: L) -> Self {
        Self { base, block_mass: None, effects: [None; MAX_EFFECTS], curves: [None; MAX_CURVES] }
    }

    /// A law with `effects`.
    ///
    /// # Errors
    /// More than [`MAX_EFFECTS`] effects.
    pub fn with(base: L, effects: &[Effect<f64>]) -> Result<Self, Invalid> {
        let mut layered = Self::new(base);
        for effect in effects {
            layered.add(*effect)?;
        }
        Ok(layered)
    }

    /// Adds one effect.
    ///
    /// # Errors
    /// There are already [`MAX_EFFECTS`] effects.
    pub fn add(&mut self, effect: Effect<f64>) -> Result<(), Invalid> {
        fill("effects", &mut self.effects, effect)
    }

    /// Adds physics without a name.
    ///
    /// # Errors
    /// There are already [`MAX_CURVES`] curves.
    pub fn add_curve(&mut self, curve: FreeForm<f64>) -> Result<(), Invalid> {
        fill("curves", &mut self.curves, curve)
    }

    /// Force on the block, N: the force on the whole moving mass less the inertia of the device, m_b·a + f with
    /// a = (F − f)/m and f of the previous step.
    fn load_on_block(&self, motion: &Motion<f64>, friction: f64) -> f64 {
        match self.block_mass {
            Some(block) if motion.mass > block => {
                let share = block / motion.mass;
                share * motion.applied + (1.0 - share) * friction
            }
            _ => motion.applied,
        }
    }

    /// The effects.
    pub fn effects(&self) -> impl Iterator<Item = &Effect<f64>> {
        self.effects.iter().flatten()
    }
}

impl<L: FrictionLaw<f64>> FrictionLaw<f64> for Layered<L> {
    type State = LayeredState<L::State>;

    #[inline]
    fn step(&self, state: &mut Self::State, motion: &Motion<f64>) -> f64 {
        let mut on_top = 0.0;
        if self.effects[0].is_some() {
            let seen = Motion { applied: self.load_on_block(motion, state.force), ..*motion };
            // effects fill the array from the front
            for (effect, memory) in self.effects.iter().zip(&mut state.effects) {
                let Some(effect) = effect else { break };
                on_top += effect.step(memory, &seen);
            }
        }
        for (curve, memory) in self.curves.iter().zip(&mut state.curves) {
            let Some(curve) = curve else { break };
            on_top += curve.step(memory, motion);
        }
        let left = Motion { applied: motion.applied - on_top, ..*motion };
        state.force = on_top + self.base.step(&mut state.base, &left);
        state.force
    }

    fn validate(&self) -> Result<(), Invalid> {
        self.base.validate()?;
        self.effects().try_for_each(Effect::validate)?;
        self.curves.iter().flatten().try_for_each(FreeForm::validate)
    }
}
