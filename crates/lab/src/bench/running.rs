//! A session under way: its task, the current trial, and what the handle should resist with.

use crate::experiment::Task;
use client::RecordingFile;
use perception::{Log, Resistance, Stimulus};

/// Resistance on the handle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Felt {
    /// Nothing is rendered; the block that is mounted, if one is.
    Bare {
        /// The real block of [thesis, table 5-2].
        block: bool,
    },
    /// This is rendered.
    Rendered(Stimulus),
}

/// A session under way.
pub(super) struct Running {
    pub(super) log: Log,
    pub(super) name: String,
    pub(super) task: Task,
    /// The subject has armed it.
    pub(super) armed: bool,
    /// Time of the device when the trial began, s.
    pub(super) since: Option<f64>,
    pub(super) trajectory: Option<(String, RecordingFile)>,
    /// Resistance sent to the device.
    pub(super) felt: Option<Felt>,
    pub(super) last: String,
}

impl Running {
    /// A session before its first trial, or before the next one.
    pub fn new(log: Log, name: String, task: Task) -> Self {
        Self { log, name, task, armed: false, since: None, trajectory: None, felt: None, last: String::new() }
    }

    /// Resistance of the next trial.
    pub fn wanted(&self) -> Felt {
        match &self.task {
            Task::Targeting(task) => match task.next().map(|segment| segment.resistance) {
                Some(Resistance::Real) => Felt::Bare { block: true },
                Some(resistance) => resistance.rendered().map_or(Felt::Bare { block: false }, Felt::Rendered),
                None => Felt::Bare { block: false },
            },
            Task::Choice(task) => match task.next() {
                Some(question) => Felt::Rendered(question.stimulus(task.case())),
                None => Felt::Bare { block: false },
            },
        }
    }

    /// Removes the trajectory of a trial that was given up.
    pub fn discard_trajectory(&mut self) {
        if let Some((_, file)) = self.trajectory.take() {
            file.discard();
        }
    }

    /// Gives up the current trial.
    pub fn abandon(&mut self) {
        self.since = None;
        self.discard_trajectory();
        match &mut self.task {
            Task::Targeting(task) => task.abandon(),
            Task::Choice(task) => task.abandon(),
        }
    }

    /// What subject or experimenter does next; empty during a trial.
    pub fn waits(&self, sim: bool) -> &'static str {
        if self.task.is_complete() {
            "That was the last one. Thank you."
        } else if !self.armed {
            "The handle is free. Arm it when you are ready."
        } else if self.since.is_none() {
            match (self.wanted(), sim) {
                (Felt::Bare { block: true }, false) => {
                    "Experimenter: mount the 0.5 kg aluminium block on its rubber pad, then start."
                }
                (Felt::Bare { block: false }, false) if matches!(self.task, Task::Targeting(_)) => {
                    "Experimenter: nothing is mounted on the handle? Then start."
                }
                _ => "Ready.",
            }
        } else {
            ""
        }
    }
}
