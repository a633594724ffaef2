//! Passivity observer and controller in the time domain [hannaford-2002], for every renderer.
//!
//! The port is the handle: the force held over a period times the path of the encoder in it is the energy given to the hand,
//! exactly, whatever the renderer does ([stramigioli-2005] for the observer with a held force).
//!
//! The *balance* is what the hand gave and may get back. It never exceeds what coupling and block store (the reference
//! energy of [ryu-2005]): without that limit a second of sliding would pay for an hour of chatter, because friction takes
//! energy for ever. A negative balance is energy that nothing stored. Before it leaves with the next force it is taken back
//! by a damping of just that amount on the handle, within the damping that the sampled device holds. By admittance the
//! handle only follows: there the block is braked by that amount instead.

use crate::Config;
use crate::renderer::{Contact, Handle};

/// State of the observer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Passivity {
    /// Energy that the hand may get back, J. Negative: it got more.
    balance: f32,
}

impl Passivity {
    /// The force to command instead of `force`, N. `held` is the force of the period that ended.
    // a function of its own: without it the step has the cycles it had before
    #[inline(never)]
    pub(crate) fn step(
        &mut self,
        config: &Config,
        contact: &mut Contact,
        handle: &Handle,
        held: f32,
        force: f32,
    ) -> f32 {
        let balance = self.balance - held * handle.displacement;
        let stored = contact.stored(config, handle);
        self.balance = if balance < stored { balance } else { stored };
        #[cfg(feature = "admittance")]
        if config.renderer == crate::RendererKind::Admittance {
            if self.balance < 0.0 {
                contact.brake(config, -self.balance);
            }
            return force;
        }
        let v = handle.velocity;
        // what a damping of one would take over the coming period
        let taken = v * v * config.device.period;
        if self.balance >= 0.0 || handle.displacement == 0.0 || !(taken > 0.0) {
            return force;
        }
        let (owed, most) = (-self.balance, config.passivity_damping);
        let damping = if owed < most * taken { owed / taken } else { most };
        force - damping * v
    }
}
