//! A complete law with left-out effects on top: the block of a rig in which something is concealed.

use friction::effects::{Effect, EffectState};
use friction::{FrictionLaw, Invalid, Motion};

/// Most effects on one block.
pub const MAX_EFFECTS: usize = 4;

/// A base law plus up to [`MAX_EFFECTS`] effects of the catalogue. It is a law itself, so a rig takes it
/// like any other.
///
/// The effects act first; what the base law may have to balance or stop is the load they leave. So friction
/// that is added on top adds to stiction, too, and a spring that pulls is held by it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layered<L> {
    /// The complete law underneath.
    pub base: L,
    /// Mass of the block, kg. Given, effects that scale with the load (`load_dependent_friction`,
    /// `torque_ripple`) see the force *on the block*, which is what a load cell between device and block
    /// measures, and what a recording calls the applied force. `None`: they see the force on everything
    /// that moves.
    pub block_mass: Option<f64>,
    effects: [Option<Effect<f64>>; MAX_EFFECTS],
}

/// Memory of a [`Layered`] law.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LayeredState<S> {
    base: S,
    effects: [EffectState<f64>; MAX_EFFECTS],
    /// Friction of the last step, N.
    force: f64,
}

impl<L> Layered<L> {
    /// A law with nothing on top.
    pub const fn new(base: L) -> Self {
        Self { base, block_mass: None, effects: [None; MAX_EFFECTS] }
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

    /// Force on the block, N: of the force on the whole moving mass, what the device's own inertia leaves.
    /// m_b·a + f with a = (F − f)/m, f that of the last step.
    fn load_on_block(&self, motion: &Motion<f64>, friction: f64) -> f64 {
        match self.block_mass {
            Some(block) if motion.mass > block => {
                let share = block / motion.mass;
                share * motion.applied + (1.0 - share) * friction
            }
            _ => motion.applied,
        }
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
        if self.effects[0].is_some() {
            let seen = Motion { applied: self.load_on_block(motion, state.force), ..*motion };
            // effects fill from the front
            for (effect, memory) in self.effects.iter().zip(&mut state.effects) {
                let Some(effect) = effect else { break };
                on_top += effect.step(memory, &seen);
            }
        }
        let left = Motion { applied: motion.applied - on_top, ..*motion };
        state.force = on_top + self.base.step(&mut state.base, &left);
        state.force
    }

    fn validate(&self) -> Result<(), Invalid> {
        self.base.validate()?;
        self.effects().try_for_each(Effect::validate)
    }
}
