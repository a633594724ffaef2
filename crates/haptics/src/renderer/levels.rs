//! Set-valued friction of a law that holds, and the velocity with which a block leaves a step under it (stopping_force.rs has
//! the equations).

use friction::Law;

/// Dry friction and its slope in one direction of motion.
#[derive(Clone, Copy)]
struct Level {
    hold: f32,
    slide: f32,
    viscous: f32,
}

impl Level {
    /// Velocity and friction, in this direction, of a block that `drive` moves beyond the holding level.
    #[inline(always)]
    fn slides(&self, drive: f32, inertia: f32) -> (f32, f32) {
        let speed = (drive - self.slide) / (inertia + self.viscous);
        let friction = self.slide + self.viscous * speed;
        // a falling slope never makes friction drive
        if friction >= 0.0 && speed > 0.0 { (speed, friction) } else { (drive / inertia, 0.0) }
    }
}

/// Solution of a step.
#[derive(Clone, Copy)]
pub(super) struct Solved {
    /// Velocity at the end of the step, m/s.
    pub velocity: f32,
    /// N.
    pub friction: f32,
    /// Mean velocity over the step, m/s.
    pub mean: f32,
}

/// Levels against positive and negative motion.
#[derive(Clone, Copy)]
pub(super) struct Levels {
    p: Level,
    n: Level,
}

impl Levels {
    /// Levels of a law that holds. `None` for any other.
    #[inline(always)]
    pub(super) fn of(law: &Law<f32>) -> Option<Self> {
        match law {
            Law::Karnopp(law) => Some(Self {
                p: Level { hold: law.d_p, slide: law.c_p, viscous: law.b_p },
                n: Level { hold: law.d_n, slide: law.c_n, viscous: law.b_n },
            }),
            Law::Coulomb(law) => Some(Self {
                p: Level { hold: law.static_p, slide: law.level_p, viscous: law.viscous_p },
                n: Level { hold: law.static_n, slide: law.level_n, viscous: law.viscous_n },
            }),
            _ => None,
        }
    }

    /// Adds friction in the direction in which the block moves or is pulled.
    pub(super) fn add(&mut self, friction: f32, direction: f32) {
        let (level, more) = if direction < 0.0 { (&mut self.n, -friction) } else { (&mut self.p, friction) };
        for side in [&mut level.hold, &mut level.slide] {
            let sum = *side + more;
            *side = if sum > 0.0 { sum } else { 0.0 };
        }
    }

    /// Solves inertia·w⁺ + F = drive for a block with the velocity w.
    #[inline(always)]
    pub(super) fn solve(&self, drive: f32, inertia: f32, w: f32) -> Solved {
        // a sliding block meets static friction only across a reversal
        let hold_p = if w > 0.0 { self.p.slide } else { self.p.hold };
        let hold_n = if w < 0.0 { self.n.slide } else { self.n.hold };
        if drive > hold_p {
            let (velocity, friction) = self.p.slides(drive, inertia);
            Solved { velocity, friction, mean: 0.5 * (w + velocity) }
        } else if drive < -hold_n {
            let (speed, friction) = self.n.slides(-drive, inertia);
            Solved { velocity: -speed, friction: -friction, mean: 0.5 * (w - speed) }
        } else {
            // it stops within the period: where a constant force brings it to zero
            let through = (if w > 0.0 { drive - self.p.slide } else { drive + self.n.slide }) / inertia;
            let mean = if w == 0.0 { 0.0 } else { 0.5 * w * w / (w - through) };
            // NaN ends here: the force shows it, the block stays in place
            Solved { velocity: 0.0, friction: drive, mean }
        }
    }
}
