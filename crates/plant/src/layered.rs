//! A complete law with left-out effects on top: the block of a rig in which something is concealed.

use friction::effects::{Effect, EffectState};
use friction::{FrictionLaw, Invalid, Motion};

/// Most effects on one block.
pub const MAX_EFFECTS: usize = 8;

/// A base law plus up to [`MAX_EFFECTS`] effects of the catalogue. It is a law itself, so a rig takes it
/// like any other.
///
/// The effects act first; what the base law may have to balance or stop is the load they leave. So friction
/// that is added on top adds to stiction, too, and a spring that pulls is held by it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layered<L> {
    /// The complete law underneath.
    pub base: L,
    effects: [Option<Effect<f64>>; MAX_EFFECTS],
}

/// Memory of a [`Layered`] law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LayeredState<S> {
    base: S,
    effects: [EffectState<f64>; MAX_EFFECTS],
}

impl<L> Layered<L> {
    /// A law with nothing on top.
    pub const fn new(base: L) -> Self {
        Self { base, effects: [None; MAX_EFFECTS] }
    }

    /// A law with `effects` on top.
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
    /// There are [`MAX_EFFECTS`] already.
    pub fn add(&mut self, effect: Effect<f64>) -> Result<(), Invalid> {
        let free = self.effects.iter_mut().find(|slot| slot.is_none()).ok_or(Invalid {
            parameter: "effects",
            value: (MAX_EFFECTS + 1) as f64,
            min: 0.0,
            max: MAX_EFFECTS as f64,
        })?;
        *free = Some(effect);
        Ok(())
    }

    /// The effects on top.
    pub fn effects(&self) -> impl Iterator<Item = &Effect<f64>> {
        self.effects.iter().flatten()
    }
}

impl<L: FrictionLaw<f64>> FrictionLaw<f64> for Layered<L> {
    type State = LayeredState<L::State>;

    #[inline]
    fn step(&self, state: &mut Self::State, motion: &Motion<f64>) -> f64 {
        let mut on_top = 0.0;
        // effects fill from the front
        for (effect, memory) in self.effects.iter().zip(&mut state.effects) {
            let Some(effect) = effect else { break };
            on_top += effect.step(memory, motion);
        }
        on_top + self.base.step(&mut state.base, &Motion { applied: motion.applied - on_top, ..*motion })
    }

    fn validate(&self) -> Result<(), Invalid> {
        self.base.validate()?;
        self.effects().try_for_each(Effect::validate)
    }
}
