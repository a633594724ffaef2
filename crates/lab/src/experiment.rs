//! An experiment as a page sees it: what to draw, without what the subject must not know.

use perception::{Case, Event, Experiment, ForcedChoice, Record, Session, Targeting};
use serde::Serialize;
use std::path::Path;

/// What is felt and asked.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant)] // one session at a time
pub enum Task {
    /// The Fitts task.
    Targeting(Targeting),
    /// Which of two differs?
    Choice(ForcedChoice),
}

impl Task {
    /// From the beginning; None for a task without a device.
    #[must_use]
    pub fn new(experiment: Experiment) -> Option<Self> {
        match experiment {
            Experiment::Targeting(plan) => Some(Self::Targeting(Targeting::new(plan))),
            Experiment::ForcedChoice(plan) => Some(Self::Choice(ForcedChoice::new(plan))),
            Experiment::Ring(_) => None,
        }
    }

    /// From where a file ends; None for a task without a device.
    #[must_use]
    pub fn resume(session: &Session) -> Option<Self> {
        match &session.header.experiment {
            Experiment::Targeting(plan) => {
                Some(Self::Targeting(Targeting::resume(plan.clone(), &session.records)))
            }
            Experiment::ForcedChoice(plan) => {
                Some(Self::Choice(ForcedChoice::resume(plan.clone(), &session.records)))
            }
            Experiment::Ring(_) => None,
        }
    }

    /// `targeting` or `forced_choice`.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Targeting(_) => "targeting",
            Self::Choice(_) => "forced_choice",
        }
    }

    /// Trials finished, and in all.
    #[must_use]
    pub fn progress(&self) -> (usize, usize) {
        match self {
            Self::Targeting(task) => task.progress(),
            Self::Choice(task) => task.progress(),
        }
    }

    /// Nothing is left to present.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        match self {
            Self::Targeting(task) => task.next().is_none(),
            Self::Choice(task) => task.next().is_none(),
        }
    }
}

/// A session of the folder.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Begun {
    /// File name.
    pub name: String,
    /// `targeting`, `forced_choice` or `plane`.
    pub kind: &'static str,
    /// Label of the subject.
    pub subject: String,
    /// Trials finished.
    pub done: usize,
    /// Trials in all.
    pub of: usize,
}

impl Begun {
    /// Reads the file of a session; None for any other file.
    #[must_use]
    pub fn read(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?.to_owned();
        let session = Session::read(path).ok()?;
        let ((done, of), kind) = match (&session.header.experiment, Task::resume(&session)) {
            (Experiment::Ring(plan), _) => {
                (perception::Ring::resume(plan.clone(), &session.records).progress(), "plane")
            }
            (_, task) => task.map(|task| (task.progress(), task.kind()))?,
        };
        Some(Self { name, kind, subject: session.header.subject.id, done, of })
    }
}

/// What a page draws.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Shown {
    /// Name of the session; its file ends in `.jsonl`.
    pub name: String,
    /// Trials finished.
    pub done: usize,
    /// Trials in all, at most.
    pub of: usize,
    /// What the subject or the experimenter has to do, if the session waits.
    pub waits: String,
    /// The subject has armed the handle.
    pub armed: bool,
    /// A trial runs.
    pub running: bool,
    /// Nothing is left.
    pub complete: bool,
    /// What the last click or answer was, in a few words.
    pub last: String,
    /// Targets.
    pub targets: Option<Targets>,
    /// Cases.
    pub cases: Option<Cases>,
}

/// The targeting task now.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Targets {
    /// It is practice.
    pub practice: bool,
    /// Between the targets' centres, pixels of the task.
    pub distance_px: f64,
    /// Width within which the centre of the cursor hits, pixels.
    pub width_px: f64,
    /// Diameter of the cursor, pixels.
    pub cursor_px: f64,
    /// Handle travel of a pixel, m.
    pub metre_per_px: f64,
    /// Which one is to be hit: −1 left, +1 right, 0 none.
    pub side: i8,
    /// Valid clicks of this segment.
    pub valid: usize,
    /// Of so many.
    pub clicks: usize,
}

/// The forced choice now.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cases {
    /// What is felt.
    pub case: Case,
    /// All three were felt.
    pub may_answer: bool,
}

impl Shown {
    /// What a page draws for a task, whatever it waits for.
    #[must_use]
    pub fn new(name: &str, task: &Task) -> Self {
        let (done, of) = task.progress();
        let (mut targets, mut cases) = (None, None);
        match task {
            Task::Targeting(task) => {
                let plan = task.plan();
                targets = task.next().map(|segment| Targets {
                    practice: segment.practice,
                    distance_px: segment.difficulty.distance_px,
                    width_px: segment.difficulty.width_px,
                    cursor_px: plan.cursor_px,
                    metre_per_px: plan.metre_per_px,
                    side: task.side().unwrap_or(0),
                    valid: task.valid_clicks(),
                    clicks: perception::CLICKS,
                });
            }
            Task::Choice(task) => {
                cases = Some(Cases { case: task.case(), may_answer: task.may_answer() });
            }
        }
        Self {
            name: name.to_owned(),
            done,
            of,
            waits: String::new(),
            armed: false,
            running: false,
            complete: task.is_complete(),
            last: String::new(),
            targets,
            cases,
        }
    }
}

/// A click in a few words, and the trial it finished.
#[must_use]
pub fn told(event: Event) -> (String, Option<Record>) {
    match event {
        Event::Valid => ("hit".into(), None),
        Event::Error(_) => ("miss".into(), None),
        Event::Finished(trial) => {
            let errors = match trial.errors {
                0 => "no misses".to_owned(),
                1 => "1 miss".to_owned(),
                many => format!("{many} misses"),
            };
            (format!("{:.2} s, {errors}", trial.completion_s), Some(Record::Targeting(trial)))
        }
    }
}

/// A moment as RFC 3339, UTC, from seconds since 1970.
#[must_use]
pub fn rfc3339(seconds: u64) -> String {
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    // the civil date of a day: years that begin in March, in eras of 400 (Hinnant, chrono-compatible algorithms)
    let z = days + 719_468;
    let (era, day_of_era) = (z / 146_097, z % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    let (hour, minute, second) = (rest / 3_600, rest / 60 % 60, rest % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, date) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_251_199, "2024-02-29T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(rfc3339(seconds), date);
        }
    }

    #[test]
    fn a_page_is_never_told_which_case_differs() {
        let task =
            Task::new(Experiment::ForcedChoice(perception::ForcedChoicePlan::thesis(1))).expect("a task");
        let text = serde_json::to_string(&Shown::new("s", &task)).expect("text");
        println!("{text}");
        assert!(!text.contains("different") && !text.contains("f_static") && !text.contains("level"));
    }
}
