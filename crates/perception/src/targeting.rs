//! The targeting task of [thesis, ch. 5.3.1]: clicks on two targets in turn, as fast as possible.
//!
//! ```text
//!   next() ── segment ──> start(t) ──> click(t, x) ──┬── Valid: the other target is next
//!     ^                                              ├── Error: the same one again, with its miss in pixels
//!     └──────────── record the trial <── Finished ───┘
//! ```

use crate::record::{Click, Record, TargetingTrial};
use crate::targeting_plan::{CLICKS, Segment, TargetingPlan};

/// Result of a click.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// Hit: the cursor was completely inside. The other target is next.
    Valid,
    /// Miss, with its distance in pixels.
    Error(f64),
    /// The eighth valid click completed the segment.
    Finished(TargetingTrial),
}

/// A running segment.
#[derive(Debug, Clone)]
struct Running {
    started_s: f64,
    /// Next target: −1 below, +1 above the centre.
    side: i8,
    clicks: Vec<Click>,
}

/// A session of the targeting task.
#[derive(Debug, Clone)]
pub struct Targeting {
    plan: TargetingPlan,
    done: usize,
    running: Option<Running>,
}

impl Targeting {
    /// A new session. A plan without an order gets the order of its seed.
    #[must_use]
    pub fn new(mut plan: TargetingPlan) -> Self {
        if plan.order.is_empty() {
            plan.order = plan.drawn();
        }
        if !plan.practice {
            plan.order.retain(|segment| !segment.practice);
        }
        Self { plan, done: 0, running: None }
    }

    /// A session resumed from the records of its file. An unfinished segment starts again.
    #[must_use]
    pub fn resume(plan: TargetingPlan, records: &[Record]) -> Self {
        let mut task = Self::new(plan);
        let finished = records.iter().filter(|record| matches!(record, Record::Targeting(_))).count();
        task.done = finished.min(task.plan.order.len());
        task
    }

    /// Plan of the session.
    #[must_use]
    pub fn plan(&self) -> &TargetingPlan {
        &self.plan
    }

    /// Number of finished segments, and total.
    #[must_use]
    pub fn progress(&self) -> (usize, usize) {
        (self.done, self.plan.order.len())
    }

    /// Next segment. `None` if the session is complete.
    #[must_use]
    pub fn next(&self) -> Option<Segment> {
        self.plan.order.get(self.done).copied()
    }

    /// Starts the segment: the targets appear at `time_s` of the trajectory's clock. A second call restarts the segment.
    pub fn start(&mut self, time_s: f64) {
        if self.next().is_some() {
            self.running = Some(Running { started_s: time_s, side: 1, clicks: Vec::with_capacity(CLICKS) });
        }
    }

    /// Aborts the running segment. It is presented again.
    pub fn abandon(&mut self) {
        self.running = None;
    }

    /// Whether a segment is running.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Present target: −1 below, +1 above the centre.
    #[must_use]
    pub fn side(&self) -> Option<i8> {
        self.running.as_ref().map(|running| running.side)
    }

    /// Number of valid clicks in this segment.
    #[must_use]
    pub fn valid_clicks(&self) -> usize {
        self.running.as_ref().map_or(0, |running| running.clicks.iter().filter(|c| c.valid).count())
    }

    /// Centre of the present target as a handle position, m from the centre of travel.
    #[must_use]
    pub fn target_m(&self) -> Option<f64> {
        let side = self.side()?;
        let segment = self.next()?;
        Some(f64::from(side) * 0.5 * segment.difficulty.distance_px * self.plan.metre_per_px)
    }

    /// Records a click at `time_s` with the handle at `position_m`. `None` without a running segment, for non-finite time or
    /// position, or if time runs backward.
    pub fn click(&mut self, time_s: f64, position_m: f64) -> Option<Event> {
        let segment = self.next()?;
        let running = self.running.as_mut()?;
        let since_s = time_s - running.started_s;
        let last_s = running.clicks.last().map_or(0.0, |click| click.time_s);
        if !position_m.is_finite() || !since_s.is_finite() || since_s < last_s {
            return None;
        }
        let d = &segment.difficulty;
        let position_px = position_m / self.plan.metre_per_px;
        let target_px = f64::from(running.side) * 0.5 * d.distance_px;
        let beside_px = ((position_px - target_px).abs() - 0.5 * d.width_px).max(0.0);
        let valid = beside_px == 0.0;
        running.clicks.push(Click { time_s: since_s, position_px, target_px, valid });
        if !valid {
            return Some(Event::Error(beside_px));
        }
        running.side = -running.side;
        if running.clicks.iter().filter(|click| click.valid).count() < CLICKS {
            return Some(Event::Valid);
        }
        let running = self.running.take()?;
        self.done += 1;
        Some(Event::Finished(TargetingTrial::new(self.done, segment, &self.plan, running.clicks)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stimulus::Resistance;

    fn hit(task: &mut Targeting, time: f64, beside_px: f64) -> Event {
        let at = task.target_m().expect("a target") + beside_px * task.plan().metre_per_px;
        task.click(time, at).expect("a segment runs")
    }

    #[test]
    fn eight_valid_clicks_complete_a_segment() {
        let plan = TargetingPlan { practice: false, ..TargetingPlan::thesis(3) };
        let mut task = Targeting::new(plan);
        assert_eq!(task.click(0.0, 0.0), None, "nothing runs yet");
        let half = 0.5 * task.next().expect("a segment").difficulty.width_px;
        task.start(10.0);
        assert_eq!(task.side(), Some(1));
        assert_eq!(hit(&mut task, 10.9, half + 5.0), Event::Error(5.0));
        assert_eq!(task.side(), Some(1), "an error does not move on");
        assert_eq!(hit(&mut task, 11.0, -half), Event::Valid, "the rim is inside");
        assert_eq!(task.side(), Some(-1));
        assert_eq!(task.click(10.95, 0.0), None, "time does not run backward");
        for k in 0..6 {
            assert_eq!(hit(&mut task, 12.0 + f64::from(k), 0.0), Event::Valid);
        }
        assert!(matches!(hit(&mut task, 18.5, -half - 1.0), Event::Error(e) if (e - 1.0).abs() < 1e-9));
        let Event::Finished(trial) = hit(&mut task, 19.0, 0.0) else { panic!("eighth valid click") };
        assert_eq!((trial.errors, trial.clicks.len()), (2, 10));
        assert!((trial.completion_s - 9.0).abs() < 1e-12);
        assert!((trial.mean_error_mm - 3.0 * 0.06).abs() < 1e-9, "{}", trial.mean_error_mm);
        assert_eq!(task.progress(), (1, 45));
    }

    #[test]
    fn an_unfinished_segment_starts_again() {
        let mut task = Targeting::new(TargetingPlan::thesis(5));
        let mut records = Vec::new();
        for _ in 0..12 {
            task.start(0.0);
            for k in 1..=8 {
                if let Event::Finished(trial) = hit(&mut task, f64::from(k), 0.0) {
                    records.push(Record::Targeting(trial));
                }
            }
        }
        task.start(0.0);
        hit(&mut task, 0.5, 0.0);
        let resumed = Targeting::resume(task.plan().clone(), &records);
        assert_eq!(resumed.progress(), (12, 47));
        assert_eq!(resumed.next(), task.next());
        assert_eq!(resumed.valid_clicks(), 0);
        assert_eq!(task.plan().order[0].resistance, Resistance::Baseline);
    }
}
