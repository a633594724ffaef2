//! The targeting task on the plane, with its file.

use friction::planar::Vector;
use perception::{Log, Record, Ring, RingPlan, RingTrial, Selection};
use serde::Serialize;
use std::path::Path;

/// A session under way.
pub struct Task {
    name: String,
    log: Log,
    ring: Ring,
    last: String,
    scores: Vec<Score>,
}

/// Result of a circle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Score {
    surface: String,
    id_bits: f64,
    errors: usize,
    bits_per_s: Option<f64>,
    effective_width_mm: Option<f64>,
    movement_s: Option<f64>,
}

/// The task now.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Circle {
    /// Name of the session; its file ends in `.jsonl`.
    pub name: String,
    /// Circles finished.
    pub done: usize,
    /// Circles in all.
    pub of: usize,
    /// Centres, m.
    pub targets: Vec<[f64; 2]>,
    /// Diameter of a target, m.
    pub width: f64,
    /// Centre of the target to select, m.
    pub target: Option<[f64; 2]>,
    /// Selections of this circle.
    pub selections: usize,
    /// The last selection, in a word.
    pub last: String,
}

impl Score {
    fn of(trial: &RingTrial) -> Self {
        let t = trial.throughput();
        Self {
            surface: trial.case.surface.clone(),
            id_bits: trial.id_bits,
            errors: trial.errors,
            bits_per_s: t.map(|t| t.bits_per_s),
            effective_width_mm: t.map(|t| t.effective_width_mm),
            movement_s: t.map(|t| t.movement_s),
        }
    }
}

impl Task {
    /// A session with a new file.
    pub fn new(name: String, log: Log, plan: RingPlan) -> Self {
        Self { name, log, ring: Ring::new(plan), last: String::new(), scores: Vec::new() }
    }

    /// Goes on where a file ends.
    ///
    /// # Errors
    /// No such session, or one of another task.
    pub fn resume(folder: &Path, file: &str) -> Result<Self, String> {
        if !crate::bench::is_name(file, ".jsonl") {
            return Err(format!("no session `{file}`"));
        }
        let (log, session) = Log::resume(&folder.join(file)).map_err(|e| e.to_string())?;
        let perception::Experiment::Ring(plan) = &session.header.experiment else {
            return Err(format!("{file}: not a session on the plane"));
        };
        let ring = Ring::resume(plan.clone(), &session.records);
        let scores = session.records.iter().filter_map(|record| {
            if let Record::Ring(trial) = record { Some(Score::of(trial)) } else { None }
        });
        let name = file.trim_end_matches(".jsonl").to_owned();
        Ok(Self { name, log, ring, last: String::new(), scores: scores.collect() })
    }

    /// Surface of the next circle.
    pub fn surface(&self) -> Option<&str> {
        self.ring.next().map(|case| case.surface.as_str())
    }

    /// Centre of the target to select, m.
    pub fn target(&self) -> Option<[f64; 2]> {
        self.ring.target()
    }

    /// The unfinished circle starts again.
    pub fn abandon(&mut self) {
        self.ring.abandon();
    }

    /// Selects what is under the puck. True when a circle was finished, and kept.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn select(&mut self, time: f64, at: Vector<f64>) -> Result<bool, String> {
        self.last = match self.ring.select(time, at.x, at.y) {
            None => return Ok(false),
            Some(Selection::Began) => "go".into(),
            Some(Selection::Selected(true)) => "hit".into(),
            Some(Selection::Selected(false)) => "miss".into(),
            Some(Selection::Finished(trial)) => {
                self.scores.push(Score::of(&trial));
                self.log.append(&Record::Ring(trial)).map_err(|e| e.to_string())?;
                self.last = "circle finished".into();
                return Ok(true);
            }
        };
        Ok(false)
    }

    /// Results of the finished circles.
    pub fn scores(&self) -> &[Score] {
        &self.scores
    }

    /// The task now.
    pub fn circle(&self) -> Circle {
        let (done, of) = self.ring.progress();
        let plan = self.ring.plan();
        let case = self.ring.next();
        Circle {
            name: self.name.clone(),
            done,
            of,
            targets: case
                .map_or_else(Vec::new, |case| (0..plan.targets).map(|k| plan.target(case, k)).collect()),
            width: case.map_or(0.0, |case| case.width_m),
            target: self.ring.target(),
            selections: self.ring.selections(),
            last: self.last.clone(),
        }
    }
}
