//! The forced choice of [thesis, ch. 5.3.2]: baseline, A and B in turn; which of the two differs from the baseline?
//!
//! ```text
//!   next() ── presentation ──> case(): Baseline ─advance()─> A ─advance()─> B ─advance()─> Baseline …
//!     ^                                                                        │ all felt
//!     └───────────────────────────── record the trial <── answer(A or B) ──────┘
//! ```

use crate::batch::{Procedure, difference};
use crate::forced_choice_plan::{Answer, Case, ForcedChoicePlan, Presentation};
use crate::quest::{Belief, QuestPlus};
use crate::record::{ForcedChoiceTrial, Record};

/// The forced choice, from its first trial to its last.
#[derive(Debug, Clone)]
pub struct ForcedChoice {
    plan: ForcedChoicePlan,
    batch: usize,
    within: usize,
    done: usize,
    quest: Option<QuestPlus>,
    case: Case,
    visits: [u32; 3],
}

impl ForcedChoice {
    /// A new session. A plan without an order gets the order of its seed.
    #[must_use]
    pub fn new(mut plan: ForcedChoicePlan) -> Self {
        if plan.order.is_empty() {
            plan.order = plan.drawn();
        }
        let mut choice =
            Self { plan, batch: 0, within: 0, done: 0, quest: None, case: Case::Baseline, visits: [1, 0, 0] };
        choice.enter();
        choice
    }

    /// A session resumed from the records of its file.
    #[must_use]
    pub fn resume(plan: ForcedChoicePlan, records: &[Record]) -> Self {
        let mut choice = Self::new(plan);
        for record in records {
            if let Record::ForcedChoice(trial) = record {
                choice.step(trial.difference_n, trial.correct);
            }
        }
        choice
    }

    /// Plan of the session.
    #[must_use]
    pub fn plan(&self) -> &ForcedChoicePlan {
        &self.plan
    }

    /// Number of finished trials, and largest total: an adaptive batch may end early.
    #[must_use]
    pub fn progress(&self) -> (usize, usize) {
        let left: usize = self.plan.order.iter().skip(self.batch).map(Vec::len).sum();
        (self.done, self.done + left.saturating_sub(self.within))
    }

    /// Next question. `None` if the session is complete.
    #[must_use]
    pub fn next(&self) -> Option<Presentation> {
        let batch = self.plan.batches.get(self.batch)?;
        let planned = self.plan.order.get(self.batch)?.get(self.within)?;
        let comparison = match (&batch.procedure, &self.quest) {
            (Procedure::Constant { comparisons, .. }, _) => {
                *comparisons.get(planned.level.checked_sub(1)?)?
            }
            (Procedure::Adaptive { varied, .. }, Some(quest)) => varied.apply(&batch.reference, quest.next()),
            (Procedure::Adaptive { .. }, None) => return None,
        };
        Some(Presentation {
            number: self.done + 1,
            batch: batch.name.clone(),
            level: planned.level,
            reference: batch.reference,
            comparison,
            difference_n: difference(&batch.reference, &comparison),
            different: planned.different,
        })
    }

    /// Case presented now.
    #[must_use]
    pub fn case(&self) -> Case {
        self.case
    }

    /// Advances to the next case: baseline, A, B, and baseline again.
    pub fn advance(&mut self) -> Case {
        let (case, place) = match self.case {
            Case::Baseline => (Case::A, 1),
            Case::A => (Case::B, 2),
            Case::B => (Case::Baseline, 0),
        };
        self.case = case;
        self.visits[place] += 1;
        case
    }

    /// Aborts the current trial. It starts again with its baseline.
    pub fn abandon(&mut self) {
        self.case = Case::Baseline;
        self.visits = [1, 0, 0];
    }

    /// Whether all three cases were presented.
    #[must_use]
    pub fn may_answer(&self) -> bool {
        self.visits.iter().all(|&count| count > 0)
    }

    /// Answer of the subject, `seconds` after the first presentation. `None` before all three cases were presented, or if
    /// the session is complete.
    pub fn answer(&mut self, answer: Answer, seconds: f64) -> Option<ForcedChoiceTrial> {
        if !self.may_answer() {
            return None;
        }
        let shown = self.next()?;
        let trial = ForcedChoiceTrial::new(&shown, answer, seconds, self.visits);
        self.step(trial.difference_n, trial.correct);
        Some(trial)
    }

    /// Present estimate of an adaptive batch.
    #[must_use]
    pub fn belief(&self) -> Option<Belief> {
        self.quest.as_ref().map(QuestPlus::belief)
    }

    /// Ends a trial.
    fn step(&mut self, difference_n: f64, correct: bool) {
        self.done += 1;
        self.within += 1;
        self.abandon();
        let mut over = self.plan.order.get(self.batch).is_none_or(|order| self.within >= order.len());
        if let Some(quest) = &mut self.quest {
            quest.answer(difference_n, correct);
            if let Some(Procedure::Adaptive { enough, .. }) =
                self.plan.batches.get(self.batch).map(|batch| &batch.procedure)
            {
                let belief = quest.belief();
                over |= belief.reached && belief.ci95.1 < enough * belief.ci95.0;
            }
        }
        if over {
            self.batch += 1;
            self.within = 0;
            self.enter();
        }
    }

    fn enter(&mut self) {
        self.quest = match self.plan.batches.get(self.batch).map(|batch| &batch.procedure) {
            Some(Procedure::Adaptive { range_n, .. }) => Some(QuestPlus::new(*range_n)),
            _ => None,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stimulus::Stimulus;

    fn right(choice: &mut ForcedChoice) -> ForcedChoiceTrial {
        let different = choice.next().expect("a question").different;
        choice.advance();
        choice.advance();
        choice.answer(different, 1.0).expect("all felt")
    }

    #[test]
    fn each_level_comes_twice_and_one_case_differs() {
        let mut choice = ForcedChoice::new(ForcedChoicePlan::thesis(4));
        let mut seen = std::collections::BTreeMap::new();
        let mut sides = [0, 0];
        while let Some(shown) = choice.next() {
            assert_eq!(shown.stimulus(Case::Baseline), Stimulus::REFERENCE);
            assert_ne!(shown.stimulus(Case::A), shown.stimulus(Case::B));
            assert_eq!(choice.answer(Answer::A, 0.0), None, "not before all three were felt");
            let trial = right(&mut choice);
            assert!(trial.correct && trial.visits == [1, 1, 1]);
            sides[usize::from(trial.different == Answer::B)] += 1;
            *seen.entry((trial.batch, trial.level)).or_insert(0) += 1;
        }
        println!("{} levels, A {} times, B {}", seen.len(), sides[0], sides[1]);
        assert_eq!(seen.len(), 15);
        assert!(seen.values().all(|&count| count == 2) && sides.iter().all(|&n| n > 5));
        assert_eq!(choice.progress(), (30, 30));
    }

    #[test]
    fn an_aborted_trial_starts_with_its_baseline() {
        let mut task = ForcedChoice::new(ForcedChoicePlan::thesis(1));
        task.advance();
        task.advance();
        assert!(task.may_answer());
        task.abandon();
        assert!(task.case() == Case::Baseline && !task.may_answer());
        assert!(task.answer(Answer::A, 1.0).is_none());
    }

    #[test]
    fn a_resumed_session_asks_the_same_questions() {
        for plan in [ForcedChoicePlan::thesis(9), ForcedChoicePlan::adaptive(9)] {
            let mut choice = ForcedChoice::new(plan.clone());
            let mut records = Vec::new();
            for k in 0..17 {
                let shown = choice.next().expect("a question");
                choice.advance();
                choice.advance();
                let wrong = if shown.different == Answer::A { Answer::B } else { Answer::A };
                let answer = if k % 4 == 0 { wrong } else { shown.different };
                records.push(Record::ForcedChoice(choice.answer(answer, 1.0).expect("all felt")));
            }
            // via the text of a file
            let text = serde_json::to_string(&records).expect("text");
            let records: Vec<Record> = serde_json::from_str(&text).expect("records");
            let resumed = ForcedChoice::resume(plan, &records);
            assert_eq!(resumed.next(), choice.next());
            assert_eq!(resumed.progress(), choice.progress());
        }
    }

    #[test]
    fn batches_can_be_defined_in_toml() {
        let text = r#"
            seed = 3
            [[batch]]
            name = "light"
            reference = { f_static = 1.0, f_dynamic = 0.8, damping = 5.0, dv = 0.01, mass = 0.5, k_vc = 8000, b_vc = 15 }
            [batch.procedure]
            procedure = "constant"
            rounds = 3
            comparisons = [
              { f_static = 1.2, f_dynamic = 1.0, damping = 5.0, dv = 0.01, mass = 0.5, k_vc = 8000, b_vc = 15 },
            ]
            [[batch]]
            name = "adaptive"
            reference = { f_static = 1.0, f_dynamic = 0.8, damping = 5.0, dv = 0.01, mass = 0.5, k_vc = 8000, b_vc = 15 }
            procedure = { procedure = "adaptive", varied = "both_up", range_n = [0.05, 2.0], trials = 30, enough = 2.0 }
        "#;
        let plan = ForcedChoicePlan::from_toml(text).expect("two batches");
        assert_eq!(plan.order.iter().map(Vec::len).collect::<Vec<_>>(), [3, 30]);
        let wrong = text.replace("range_n = [0.05, 2.0]", "range_n = [2.0, 0.05]");
        assert!(ForcedChoicePlan::from_toml(&wrong).is_err_and(|e| e.contains("range_n")));
        let wrong = text.replace("rounds = 3", "round = 3");
        assert!(ForcedChoicePlan::from_toml(&wrong).is_err_and(|e| e.contains("round")));
    }
}
