//! Feed-forward of what was found of the device itself: its friction, its damping, and forces of its position (cogging,
//! ripple, gravity). It belongs to the machine, not to the rendered contact, and is added to the force of that.
//!
//! Sliding friction F is fed forward in a direction between −1 and 1:
//!
//! ```text
//! d = u + (1 − |u|)·clamp(p/p_s),   u = clamp(v/v_s)
//! force = share·F(d)·d + share·b·v + share·Σ effects(x)
//! ```
//!
//! The velocity v says the direction from v_s on; a resting handle follows the push p of the hand on the load cell, behind a
//! low-pass. Without p a handle breaks away only at the whole friction; by velocity and intended direction together
//! [bernstein-2005] it does at a tenth of it.
//!
//! **Why it has no limit cycle.** The force that d scales never exceeds share·F in its own direction. Held over a period it
//! gives the handle at most share·F·|Δx| while friction takes at least F·|Δx|: for share < 1 the device stays passive,
//! whatever noise and delay do to d. A feed-forward above the friction that is there drives a limit cycle
//! [armstrong-1994]. What remains is sampled: the negative damping share·b and the slope K of effects over the position
//! need b > share·b + share·K·(T/2 + delay) [colgate-1997].
//!
//! [`Compensation`] is what people set (`settings`: by name, validated); the loop runs the `gains` that are built from it, in the
//! step of `feed_forward`.

pub(crate) mod feed_forward;
pub(crate) mod gains;
mod settings;

use friction::effects::Effect;

/// Largest number of effects of the device that are fed forward.
pub const MAX_FED: usize = 2;
/// Largest share: a friction that is a tenth less than what was found still holds the handle.
pub const LARGEST_SHARE: f32 = 0.9;
/// Speed from which it says the direction, m/s: at a tenth of it less is left of the friction, but a handle that friction stops
/// passes it within two periods, which is a click.
pub(crate) const SPEED: f32 = 5e-3;
/// Push of the hand at rest from which its direction is taken, N: seven deviations of the filtered load cell.
pub(crate) const PUSH: f32 = 0.1;
/// Cycles that it adds to a control step on the NUCLEO-G474RE at worst without effects, rounded up. `tests/elf/cycles.rs`
/// measures them.
pub const COMPENSATION_CYCLES: u32 = 150;

/// What was found of the device, and how much of it is fed forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compensation {
    /// Share of everything below that is fed forward. 0: off.
    pub share: f32,
    /// Sliding friction of the device in positive direction, N.
    pub friction_p: f32,
    /// In negative direction, N.
    pub friction_n: f32,
    /// Viscous damping of the device, N·s/m.
    pub damping: f32,
    /// Speed v_s, m/s.
    pub speed: f32,
    /// Push p_s, N.
    pub push: f32,
    /// Forces of the position.
    pub effects: [Option<Effect<f32>>; MAX_FED],
}

impl Compensation {
    /// The same on the default device.
    pub(crate) const NONE: Self = Self {
        share: 0.0,
        friction_p: 0.0,
        friction_n: 0.0,
        damping: 0.0,
        speed: SPEED,
        push: PUSH,
        effects: [None; MAX_FED],
    };

    /// Whether anything is fed forward.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.share > 0.0
    }
}
