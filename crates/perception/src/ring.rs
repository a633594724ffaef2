//! The targeting task in the plane: targets on a circle, each movement across it [iso-9241-411, annex B].
//!
//! ```text
//!   next() ── case ──> start(t) ──> select(t, x, y) ──┬── Began: the first target was hit, time begins
//!     ^                                               ├── Selected(hit): the next target, hit or missed
//!     └──────────── record the trial <── Finished ────┘
//! ```

use crate::record::{Record, RingClick, RingTrial};
use crate::ring_plan::{RingCase, RingPlan};

/// Result of a selection.
#[derive(Debug, Clone, PartialEq)]
pub enum Selection {
    /// The first target was hit: time begins. Before that, misses do not count.
    Began,
    /// Hit or miss. The next target follows.
    Selected(bool),
    /// The circle is complete.
    Finished(RingTrial),
}

/// A session of the task.
#[derive(Debug, Clone)]
pub struct Ring {
    plan: RingPlan,
    done: usize,
    running: Option<(f64, Vec<RingClick>)>,
}

impl Ring {
    /// A new session.
    #[must_use]
    pub fn new(plan: RingPlan) -> Self {
        Self { plan, done: 0, running: None }
    }

    /// A session resumed from the records of its file. An unfinished circle starts again.
    #[must_use]
    pub fn resume(plan: RingPlan, records: &[Record]) -> Self {
        let finished = records.iter().filter(|record| matches!(record, Record::Ring(_))).count();
        Self { done: finished.min(plan.order.len()), ..Self::new(plan) }
    }

    /// Plan of the session.
    #[must_use]
    pub fn plan(&self) -> &RingPlan {
        &self.plan
    }

    /// Number of finished circles, and total.
    #[must_use]
    pub fn progress(&self) -> (usize, usize) {
        (self.done, self.plan.order.len())
    }

    /// Next circle. `None` if the session is complete.
    #[must_use]
    pub fn next(&self) -> Option<&RingCase> {
        self.plan.order.get(self.done)
    }

    /// Number of selections of this circle.
    #[must_use]
    pub fn selections(&self) -> usize {
        self.running.as_ref().map_or(0, |(_, clicks)| clicks.len())
    }

    /// Centre of the present target, m from the centre of the circle.
    #[must_use]
    pub fn target(&self) -> Option<[f64; 2]> {
        Some(self.plan.target(self.next()?, self.selections()))
    }

    /// Aborts the circle. It is presented again.
    pub fn abandon(&mut self) {
        self.running = None;
    }

    /// Records a selection at `time_s`, `x_m`, `y_m`. `None` in a complete session, for a first selection that misses, for
    /// numbers that are not finite, or if time does not advance.
    pub fn select(&mut self, time_s: f64, x_m: f64, y_m: f64) -> Option<Selection> {
        let case = self.next()?.clone();
        let [target_x_m, target_y_m] = self.target()?;
        let hit = (x_m - target_x_m).hypot(y_m - target_y_m) <= 0.5 * case.width_m;
        let click = |time_s| RingClick { time_s, x_m, y_m, target_x_m, target_y_m, hit };
        if ![time_s, x_m, y_m].iter().all(|x| x.is_finite()) {
            return None;
        }
        let Some((began, clicks)) = &mut self.running else {
            if hit {
                self.running = Some((time_s, vec![click(0.0)]));
                return Some(Selection::Began);
            }
            return None;
        };
        let since = time_s - *began;
        if since <= clicks.last()?.time_s {
            return None;
        }
        clicks.push(click(since));
        if clicks.len() <= self.plan.targets {
            return Some(Selection::Selected(hit));
        }
        let (_, clicks) = self.running.take()?;
        self.done += 1;
        Some(Selection::Finished(RingTrial {
            number: self.done,
            id_bits: case.bits(),
            case,
            errors: clicks.iter().filter(|click| !click.hit).count(),
            completion_s: since,
            clicks,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_target_lies_across_and_comes_once() {
        let plan = RingPlan::new(&["brass"], 1);
        let case = &plan.order[0];
        let places: Vec<[f64; 2]> = (0..=plan.targets).map(|k| plan.target(case, k)).collect();
        assert_eq!(places[0], places[plan.targets]);
        // the chord over (n + 1)/2 of n places: D cos(π/2n)
        let chord = case.diameter_m * (std::f64::consts::PI / 26.0).cos();
        for pair in places.windows(2) {
            let length = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
            assert!((length - chord).abs() < 1e-12, "{length}");
        }
        for (k, a) in places[..plan.targets].iter().enumerate() {
            assert!(places[..k].iter().all(|b| (a[0] - b[0]).hypot(a[1] - b[1]) > 0.01));
        }
    }

    #[test]
    fn throughput_of_a_circle_matches_a_hand_calculation() {
        let mut task = Ring::new(RingPlan {
            seed: 0,
            targets: 5,
            order: vec![RingCase { surface: "teflon".into(), diameter_m: 0.06, width_m: 0.004 }],
        });
        assert_eq!(task.select(0.0, 0.0, 0.0), None, "the first target is not in the middle");
        // each selection overshoots by 0, 1, −1, 3 and 0 mm along the movement, and misses by 0.5 mm across it
        let off = [0.0, 0.0, 1e-3, -1e-3, 3e-3, 0.0];
        let mut before = task.target().expect("a target");
        let mut end = None;
        for (k, off) in off.iter().enumerate() {
            let [x, y] = task.target().expect("a target");
            let length = (x - before[0]).hypot(y - before[1]).max(1e-12);
            let (a, b) = ((x - before[0]) / length, (y - before[1]) / length);
            let beside = if k == 0 { 0.0 } else { 0.5e-3 };
            before = [x, y];
            end = task.select(2.0 + 0.5 * k as f64, x + off * a - beside * b, y + off * b + beside * a);
        }
        let Some(Selection::Finished(trial)) = end else { panic!("{end:?}") };
        assert_eq!((trial.errors, trial.clicks.len(), trial.id_bits), (1, 6, 4.0));
        assert!((trial.completion_s - 2.5).abs() < 1e-12);
        let t = trial.throughput().expect("five movements");
        println!("{t:?}");
        // mean 0.6 mm, deviations −0.6 0.4 −1.6 2.4 −0.6: variance 9.2/4
        assert!((t.effective_width_mm - 4.133 * (9.2_f64 / 4.0).sqrt()).abs() < 1e-9);
        assert!((t.movement_s - 0.5).abs() < 1e-12 && t.movements == 5);
        assert!(
            (t.bits_per_s - 2.0 * (t.effective_distance_mm / t.effective_width_mm + 1.0).log2()).abs() < 1e-9
        );
        // 60 mm·cos(18°) = 57.06 mm, with what each movement inherits of the selection before
        assert!((t.effective_distance_mm - 57.06).abs() < 1.0);
        assert_eq!(task.progress(), (1, 1));
    }

    #[test]
    fn an_even_ring_is_refused() {
        let plan = RingPlan { targets: 12, ..RingPlan::new(&["brass"], 1) };
        assert_eq!(plan.validate(), Err("targets = 12: an odd number from 3 to 51 is accepted".into()));
    }
}
