//! Velocity from encoder counts and the times of their edges (M/T).
//!
//! With every sample the hardware latches the count and the time of the last edge. The position at an edge is known
//! exactly: an edge into a count from below lies half a count below it, from above half a count above. So
//!
//! v = (travel between the last edges of two samples) / (time between those two edges)
//!
//! * is exact at constant speed but for one timer tick (6·10⁻⁶ of v over 1 ms), however slow: at 0.05 mm/s edges are
//!   51 ms apart and the interval, not the period, is measured;
//! * counts an edge crossed back and forth as *no* travel: dither at rest is not speed;
//! * needs no filter. Its lag is half the edge interval plus the age of the last edge: about T/2 while there are
//!   edges in every period, and it grows only as motion becomes too slow to see.
//!
//! An edge may be counted in one sample and timed in the next, when the capture takes longer than the reading. It then counts
//! as an edge at the sample, which is true to within the reading, and its time corrects the age later.
//!
//! Between edges the handle has moved less than one count since the last one, so |v| is bounded by one count over the
//! age of that edge: the estimate falls smoothly as 1/age and never holds a stale value. The age is accumulated from
//! sample to sample and saturates, so that a timer that wraps (32 bits at 170 MHz: 25 s) cannot make an old edge look
//! young; after 2³⁰ ticks (6.3 s, 0.4 µm/s) the handle is at rest and v is exactly 0.

/// Age at which an edge is forgotten, ticks.
const FORGOTTEN: u32 = 1 << 30;

/// Which side the count was entered from at its last edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Entered {
    /// Not known: after power-up, or after an even number of edges within one period.
    Unknown,
    /// Counting up.
    FromBelow,
    /// Counting down.
    FromAbove,
}

/// The estimator: integer state only, so it is finite whatever comes in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimator {
    started: bool,
    sample_ticks: u32,
    count: u32,
    edge_ticks: u32,
    /// Age of the last edge at the last sample, ticks, saturating at [`FORGOTTEN`].
    age: u32,
    entered: Entered,
    /// The last edge was counted, but its time was not there yet.
    untimed: bool,
    /// Last velocity that edges proved, counts per tick.
    proven: f32,
    velocity: f32,
    step: i32,
}

impl Default for Estimator {
    fn default() -> Self {
        Self {
            started: false,
            sample_ticks: 0,
            count: 0,
            edge_ticks: 0,
            age: FORGOTTEN,
            entered: Entered::Unknown,
            untimed: false,
            proven: 0.0,
            velocity: 0.0,
            step: 0,
        }
    }
}

impl Estimator {
    /// Takes one sample: time, count, and time of the last edge before it, all in ticks of one free-running timer.
    pub fn sample(&mut self, sample_ticks: u32, count: u32, edge_ticks: u32) {
        if !self.started {
            *self = Self { started: true, sample_ticks, count, edge_ticks, ..Self::default() };
            return;
        }
        let elapsed = sample_ticks.wrapping_sub(self.sample_ticks);
        let step = count.wrapping_sub(self.count) as i32;
        // an edge in this period is younger than the period; anything older was seen before
        let since_edge = sample_ticks.wrapping_sub(edge_ticks);
        let timed = edge_ticks != self.edge_ticks && since_edge <= elapsed;
        if step != 0 {
            // an edge without its time has just come, or the capture failed and the sample is all there is
            self.edge(step, elapsed, if timed { since_edge } else { 0 });
            self.untimed = !timed;
        } else if timed && self.untimed {
            self.age = since_edge;
            self.untimed = false;
        } else if timed {
            self.edge(0, elapsed, since_edge);
        } else {
            self.age = self.age.saturating_add(elapsed).min(FORGOTTEN);
        }
        self.velocity = if self.age >= FORGOTTEN {
            self.proven = 0.0;
            0.0
        } else {
            let bound = 1.0 / self.age.max(1) as f32;
            if self.proven > bound {
                bound
            } else if self.proven < -bound {
                -bound
            } else {
                self.proven
            }
        };
        self.sample_ticks = sample_ticks;
        self.count = count;
        self.edge_ticks = edge_ticks;
        self.step = step;
    }

    /// One or more edges since the last sample, `step` counts in all, the last of them `since_edge` ticks ago.
    fn edge(&mut self, step: i32, elapsed: u32, since_edge: u32) {
        let counts = step.unsigned_abs();
        let now = match step.signum() {
            1 => Entered::FromBelow,
            -1 => Entered::FromAbove,
            _ => Entered::Unknown,
        };
        // travel between the two edges: a full count for each step, less the one that was crossed both ways. Not
        // knowing the side counts as crossed both ways, so what is not proven is not speed.
        let travelled = if counts > 0 && now == self.entered { counts } else { counts.saturating_sub(1) };
        // time between the two edges; `age` was taken at the last sample
        let between = self.age.saturating_add(elapsed).saturating_sub(since_edge).max(1);
        let mut speed = travelled as f32 / between as f32;
        // After a pause `between` is mostly pause. All edges but the first came after the last sample, so the speed
        // among them is at least this; at constant speed it is never the larger one.
        let within = elapsed.saturating_sub(since_edge).max(1);
        let floor = counts.saturating_sub(1) as f32 / within as f32;
        if floor > speed {
            speed = floor;
        }
        self.proven = if step < 0 { -speed } else { speed };
        self.entered = now;
        self.age = since_edge;
    }

    /// Velocity in counts per tick.
    #[must_use]
    pub fn counts_per_tick(&self) -> f32 {
        self.velocity
    }

    /// Counts moved during the last period.
    #[must_use]
    pub fn step(&self) -> i32 {
        self.step
    }

    /// Position in counts, two's complement.
    #[must_use]
    pub fn counts(&self) -> i32 {
        self.count as i32
    }

    /// Age of the last edge at the last sample, ticks; saturates at 2³⁰.
    #[must_use]
    pub fn edge_age(&self) -> u32 {
        self.age
    }
}
