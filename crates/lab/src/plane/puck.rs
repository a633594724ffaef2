//! The puck, the hand that pulls it, and the work.

use super::Surface;
use friction::planar::Vector;
use haptics::planar::{Block, Coupling, Rendered};
use serde::Serialize;

/// Half width and half height of the plane, m.
pub const REACH: [f64; 2] = [0.06, 0.045];

/// Block and coupling: soft enough that a hand at a mouse sees the spring stretch, by 9 mm on rubber.
pub const COUPLING: Coupling<f64> =
    Coupling { period: 1e-3, mass: 0.2, stiffness: 400.0, damping: 12.0, force_max: 12.0 };

/// Rate at which the hand follows the pointer, critically damped, rad/s: events at 60 Hz become a smooth motion.
const FOLLOW: f64 = 80.0;

/// One step: time s; hand, puck m; pull of the coupling on the puck, friction N; 1 when stuck.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row(pub f64, pub [f32; 8], pub u8);

/// Energy since the surface was chosen, J; in the field, above the bottom of a well.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Work {
    /// Given by the hand.
    pub hand: f64,
    /// Lost to friction.
    pub friction: f64,
    /// Stored in the field of the surface; comes back.
    pub field: f64,
    /// In the spring, in the motion of the puck, and lost in the damper of the coupling.
    pub coupling: f64,
}

/// The puck and the hand.
#[derive(Debug, Clone, Copy)]
pub struct Puck {
    steps: u64,
    block: Block<f64>,
    hand: Vector<f64>,
    speed: Vector<f64>,
    target: Option<Vector<f64>>,
    work: Work,
    /// Energy in the field when the puck was put there, J.
    lifted: f64,
}

impl Default for Puck {
    fn default() -> Self {
        let middle = Vector::default();
        Self {
            steps: 0,
            block: Block::at(middle),
            hand: middle,
            speed: middle,
            target: None,
            work: Work::default(),
            lifted: 0.0,
        }
    }
}

impl Puck {
    /// The hand goes there, m; kept inside the plane.
    ///
    /// # Errors
    /// A coordinate that is not finite.
    pub fn pull(&mut self, to: Vector<f64>) -> Result<(), String> {
        if !(to.x.is_finite() && to.y.is_finite()) {
            return Err("the hand: two finite numbers in m are accepted".into());
        }
        let [x, y] = REACH;
        self.target = Some(Vector { x: to.x.clamp(-x, x), y: to.y.clamp(-y, y) });
        Ok(())
    }

    /// The hand lets go.
    pub fn let_go(&mut self) {
        self.target = None;
    }

    /// Puts the puck on another surface: it rests there, and the work begins at zero.
    pub fn put_on(&mut self, surface: &Surface) {
        self.block = Block::at(self.block.position);
        self.lifted = surface.stored(self.block.position);
        self.work = Work { field: self.lifted, ..Work::default() };
    }

    /// Time since the plane was made, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.steps as f64 * COUPLING.period
    }

    /// Where the puck is, m.
    #[must_use]
    pub fn position(&self) -> Vector<f64> {
        self.block.position
    }

    /// Energy since the surface was chosen.
    #[must_use]
    pub fn work(&self) -> Work {
        self.work
    }

    /// One millisecond.
    pub fn step(&mut self, surface: &Surface) -> Row {
        let dt = COUPLING.period;
        let from = self.hand;
        match self.target {
            Some(target) => {
                let pull = (target - self.hand) * (FOLLOW * FOLLOW) - self.speed * (2.0 * FOLLOW);
                self.speed = self.speed + pull * dt;
                self.hand = self.hand + self.speed * dt;
            }
            // a free hand is where the puck is and only brakes it: else a puck let go on detents would swing for ever
            None => (self.hand, self.speed) = (self.block.position, Vector::default()),
        }
        let held = self.target.is_some();
        let before = surface.field(self.block.position);
        let felt: Rendered<f64> =
            COUPLING.step(&mut self.block, &surface.law(), self.hand, self.speed, |_| before);
        let pull = -felt.force;
        if held {
            self.work.hand += pull.dot(self.hand - from);
        }
        self.work.friction += felt.friction.dot(felt.displacement);
        let mean = (before + surface.field(self.block.position)) * 0.5;
        self.work.field -= mean.dot(felt.displacement);
        let kept = self.work.friction + self.work.field;
        self.work.coupling = self.work.hand + self.lifted - kept;
        self.steps += 1;
        let (hand, at, friction) = (self.hand, self.block.position, felt.friction);
        let row = [hand.x, hand.y, at.x, at.y, pull.x, pull.y, friction.x, friction.y];
        Row(self.time(), row.map(|x| x as f32), u8::from(felt.stuck))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drag(puck: &mut Puck, surface: &Surface, to: (f64, f64), steps: usize) -> Vec<Row> {
        puck.pull(Vector { x: to.0, y: to.1 }).expect("finite");
        (0..steps).map(|_| puck.step(surface)).collect()
    }

    #[test]
    fn the_coupling_is_stable_at_a_held_hand() {
        COUPLING.validate().expect("inside the bound");
    }

    #[test]
    fn a_puck_at_rest_is_pulled_by_less_than_its_level() {
        for surface in &Surface::ALL[..4] {
            let mut puck = Puck::default();
            for k in 0..8 {
                let angle = f64::from(k);
                drag(&mut puck, surface, (0.03 * angle.cos(), 0.03 * angle.sin()), 700);
                let last = puck.step(surface);
                let edge = surface.edge();
                // inside the convex edge: on the inner side of every chord
                let pull = [f64::from(last.1[4]), f64::from(last.1[5])];
                let inside = edge.iter().zip(edge.iter().cycle().skip(1)).all(|(a, b)| {
                    (b[0] - a[0]) * (pull[1] - a[1]) - (b[1] - a[1]) * (pull[0] - a[0]) >= -1e-2
                });
                assert!(last.2 == 1 && inside, "{}: {last:?}", surface.name);
            }
        }
    }

    #[test]
    fn detents_give_their_work_back_and_rubber_does_not() {
        let detents = Surface::named("detents").expect("known");
        let mut puck = Puck::default();
        let mut most = 0.0_f64;
        // slowly to the next ridge and back into the well where it began
        for k in 0..4_000 {
            let there = 0.004 * (1.0 - (std::f64::consts::TAU * f64::from(k) / 4_000.0).cos());
            puck.pull(Vector { x: 0.5 * there, y: 0.0 }).expect("finite");
            puck.step(&detents);
            most = most.max(puck.work().field);
        }
        let work = puck.work();
        println!("detents: {most:e} J at most stored, {work:?}");
        assert!(most > 1e-4 && work.field.abs() < 0.02 * most && work.friction == 0.0);
        // by the integral of F sin(2πx/λ): F λ/2π (1 − cos), at a third of the way between two wells
        let half = 1.0 * 0.01 / std::f64::consts::TAU * 1.5;
        let stored = detents.stored(Vector { x: 0.01 / 3.0, y: -0.02 });
        assert!((stored / half - 1.0).abs() < 1e-4, "{stored}");
        let rubber = Surface::named("rubber").expect("known");
        let mut puck = Puck::default();
        drag(&mut puck, &rubber, (0.03, 0.0), 600);
        let to = puck.position().x;
        let lost = puck.work().friction;
        println!("rubber: {lost:e} J over {to} m");
        // at least dynamic friction times way: 3.03 N is the mean of [thesis, table 3-3]
        assert!(lost > 3.0 * to && to > 0.01);
    }

    #[test]
    fn a_puck_let_go_on_detents_swung_for_ever() {
        let detents = Surface::named("detents").expect("known");
        let mut puck = Puck::default();
        drag(&mut puck, &detents, (0.013, 0.002), 700);
        puck.let_go();
        let rows: Vec<Row> = (0..2_000).map(|_| puck.step(&detents)).collect();
        let last = &rows[rows.len() - 50..];
        assert!(last.iter().all(|row| row.1[2] == last[0].1[2] && row.1[4].abs() < 1e-6), "{:?}", last[0]);
    }

    #[test]
    fn a_hand_outside_stays_inside_and_nonsense_is_refused() {
        let mut puck = Puck::default();
        drag(&mut puck, &Surface::ALL[1], (1.0, -1.0), 2_000);
        assert!(puck.hand.x <= REACH[0] + 1e-6 && puck.hand.y >= -REACH[1] - 1e-6);
        assert!(puck.pull(Vector { x: f64::NAN, y: 0.0 }).is_err());
    }
}
