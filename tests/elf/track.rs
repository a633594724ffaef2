//! What really happened at the rig while it happened, beside what the device streamed.

use crate::board::Board;
use link::Sample;
use plant::Hand;
use std::sync::{Arc, Mutex};

/// Between two entries of the log, s.
const EVERY: f64 = 0.25e-3;

/// Time s, position m, velocity m/s.
type Entry = (f64, f64, f64);

/// A hand that writes down how the handle moves.
pub struct Witness<H> {
    hand: H,
    log: Arc<Mutex<Vec<Entry>>>,
    next: f64,
}

impl<H: Hand> Hand for Witness<H> {
    fn force(&mut self, t: f64, x: f64, v: f64) -> f64 {
        if t >= self.next {
            self.next = t + EVERY;
            self.log.lock().expect("one writer").push((t, x, v));
        }
        self.hand.force(t, x, v)
    }

    fn mass(&self) -> f64 {
        self.hand.mass()
    }
}

/// The rig's motion.
#[derive(Clone, Default)]
pub struct Track(Arc<Mutex<Vec<Entry>>>);

impl Track {
    /// A hand whose doing is tracked.
    pub fn of<H: Hand>(&self, hand: H) -> Witness<H> {
        Witness { hand, log: Arc::clone(&self.0), next: 0.0 }
    }

    /// Position and velocity at a time: the cubic through the entries around it.
    pub fn at(&self, t: f64) -> Option<(f64, f64)> {
        let log = self.0.lock().expect("one writer");
        let k = log.partition_point(|e| e.0 <= t);
        let (&(t0, x0, v0), &(t1, x1, v1)) = (log.get(k.checked_sub(1)?)?, log.get(k)?);
        let h = t1 - t0;
        let u = (t - t0) / h;
        let (a, b) = (x1 - x0 - v0 * h, (v1 - v0) * h);
        // x = x0 + v0·h·u + (3a − b)·u² + (b − 2a)·u³
        let (c2, c3) = (3.0 * a - b, b - 2.0 * a);
        let x = x0 + v0 * h * u + c2 * u * u + c3 * u * u * u;
        Some((x, v0 + (2.0 * c2 * u + 3.0 * c3 * u * u) / h))
    }

    /// Adds to the times of the device's timer to make them the rig's: the shift that fits the counts best.
    pub fn shift(&self, samples: &[Sample], metre_per_count: f64) -> f64 {
        let mut shift = 0.0;
        for _ in 0..30 {
            let (mut over, mut under) = (0.0, 0.0);
            for s in samples {
                let Some((x, v)) = self.at(seconds(s) + shift) else { continue };
                over += (f64::from(s.count) * metre_per_count - x) * v;
                under += v * v;
            }
            shift += over / under;
        }
        shift
    }
}

/// Time of a sample by the device's timer, s; good for the 25 s until it wraps.
pub fn seconds(sample: &Sample) -> f64 {
    f64::from(sample.sample_ticks) / 170e6
}

/// Runs the board up to this time of the rig, s.
pub fn run_to(board: &mut Board, t: f64) {
    let left = |board: &Board| 1e3 * t - board.machine.milliseconds();
    // what is less than a microsecond away is reached: a shorter run would not move
    while left(board) > 1e-3 {
        board.run(left(board).min(50.0));
    }
}
