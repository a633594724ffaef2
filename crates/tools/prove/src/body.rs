//! The body without anything hidden, and what an effect may look at.

/// The body that the baseline describes; forces in N or N·m, lengths in half strokes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body {
    /// Force for 1 half stroke/s².
    pub mass: f64,
    /// Coulomb friction, forward and backward.
    pub coulomb: [f64; 2],
    /// Force for 1 half stroke/s, forward and backward.
    pub viscous: [f64; 2],
}

impl Body {
    /// What the baseline says of a motion.
    pub(crate) fn force(&self, acceleration: f64, velocity: f64) -> f64 {
        let i = usize::from(velocity < 0.0);
        self.mass * acceleration + velocity.signum() * self.coulomb[i] + self.viscous[i] * velocity
    }
}

/// What an effect may look at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct State {
    /// Position, half strokes.
    pub y: f64,
    /// Velocity, half strokes/s.
    pub w: f64,
    /// Acceleration of the step before, half strokes/s².
    pub a: f64,
    /// Distance slid in the last moments, half strokes.
    pub slid: f64,
    /// Time since the recording began, s.
    pub t: f64,
    /// Length of the recording, s.
    pub seconds: f64,
    /// Load on the contact, as a share of its mean.
    pub load: f64,
    /// Age of the contact, s.
    pub age: f64,
    /// State of a rate-and-state contact, s.
    pub theta: f64,
    /// Force of the drive on the body.
    pub drive: f64,
    /// Direction of the velocity that friction follows late.
    pub late: f64,
}
