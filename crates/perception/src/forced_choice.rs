//! The forced choice of ch. 5.3.2: baseline, A and B in turn; which of the two differs from the baseline?
//!
//! ```text
//!   next() ── presentation ──> case(): Baseline ─advance()─> A ─advance()─> B ─advance()─> Baseline …
//!     ^                                                                        │ all felt
//!     └───────────────────────────── record the trial <── answer(A or B) ──────┘
//! ```

use crate::batch::{Batch, Procedure, difference};
use crate::quest::{Belief, QuestPlus};
use crate::record::{Answer, ForcedChoiceTrial, Record};
use crate::stimulus::Stimulus;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// One of the three that are felt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Case {
    /// The reference.
    Baseline,
    /// First comparison.
    A,
    /// Second comparison.
    B,
}

/// A trial as planned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Planned {
    /// Which comparison of its batch, from 1; 0: the procedure chooses.
    pub level: usize,
    /// Which case differs.
    pub different: Answer,
}

/// What is presented. It is written into the session's file whole, so that a session resumes as it began.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForcedChoicePlan {
    /// Seed of the order and of the sides.
    #[serde(default)]
    pub seed: u64,
    /// One after the other.
    #[serde(rename = "batch")]
    pub batches: Vec<Batch>,
    /// Trials of each batch; made from the seed when empty.
    #[serde(default)]
    pub order: Vec<Vec<Planned>>,
}

impl ForcedChoicePlan {
    /// These batches, in the order of the seed.
    #[must_use]
    pub fn new(seed: u64, batches: Vec<Batch>) -> Self {
        let mut plan = Self { seed, batches, order: Vec::new() };
        plan.order = plan.drawn();
        plan
    }

    /// Batches 1 to 3 of the thesis: 30 trials.
    #[must_use]
    pub fn thesis(seed: u64) -> Self {
        Self::new(seed, (1..=3).filter_map(Batch::printed).collect())
    }

    /// The same three questions, with levels that QUEST+ chooses.
    #[must_use]
    pub fn adaptive(seed: u64) -> Self {
        Self::new(seed, (1..=3).filter_map(Batch::adaptive).collect())
    }

    /// Batches of one's own, from TOML (`[[batch]]` with `name`, `reference` and `procedure`).
    ///
    /// # Errors
    /// Line, and what is accepted there; or the first batch that cannot be presented.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let mut plan: Self = toml::from_str(text).map_err(|e| e.to_string().trim().to_owned())?;
        plan.validate()?;
        if plan.order.is_empty() {
            plan.order = plan.drawn();
        }
        Ok(plan)
    }

    /// The order from the seed: within each round every level once in random order; the side that differs is a fair
    /// coin each time.
    #[must_use]
    pub fn drawn(&self) -> Vec<Vec<Planned>> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut order = Vec::new();
        for batch in &self.batches {
            let levels: Vec<usize> = match &batch.procedure {
                Procedure::Constant { comparisons, rounds } => (0..*rounds)
                    .flat_map(|_| {
                        let mut round: Vec<usize> = (1..=comparisons.len()).collect();
                        round.shuffle(&mut rng);
                        round
                    })
                    .collect(),
                Procedure::Adaptive { trials, .. } => vec![0; *trials],
            };
            let mut side = || if rng.random_bool(0.5) { Answer::A } else { Answer::B };
            order.push(levels.into_iter().map(|level| Planned { level, different: side() }).collect());
        }
        order
    }

    /// What cannot be presented.
    ///
    /// # Errors
    /// Batch, parameter, value and what would be accepted.
    pub fn validate(&self) -> Result<(), String> {
        if self.batches.is_empty() {
            return Err("no batch: at least one is accepted".into());
        }
        for (k, batch) in self.batches.iter().enumerate() {
            batch.validate()?;
            if self.batches[..k].iter().any(|other| other.name == batch.name) {
                return Err(format!(
                    "batch `{}`: a second one of this name; another is accepted",
                    batch.name
                ));
            }
        }
        if self.order.is_empty() {
            return Ok(());
        }
        if self.order.len() != self.batches.len() {
            let (orders, batches) = (self.order.len(), self.batches.len());
            return Err(format!("order of {orders} batches: one of {batches} is accepted"));
        }
        for (batch, order) in self.batches.iter().zip(&self.order) {
            let most = match &batch.procedure {
                Procedure::Constant { comparisons, .. } => 1..=comparisons.len(),
                Procedure::Adaptive { .. } => 0..=0,
            };
            if let Some(bad) = order.iter().find(|planned| !most.contains(&planned.level)) {
                return Err(format!(
                    "batch `{}`: level {} in its order: {} to {} are accepted",
                    batch.name,
                    bad.level,
                    most.start(),
                    most.end()
                ));
            }
        }
        Ok(())
    }
}

/// One question.
#[derive(Debug, Clone, PartialEq)]
pub struct Presentation {
    /// Trial, from 1.
    pub number: usize,
    /// Its batch.
    pub batch: String,
    /// Level within the batch, from 1; 0 when a procedure chose it.
    pub level: usize,
    /// What the baseline is.
    pub reference: Stimulus,
    /// What differs.
    pub comparison: Stimulus,
    /// By how much, N.
    pub difference_n: f64,
    /// Which case differs; not for the subject to see.
    pub different: Answer,
}

impl Presentation {
    /// What is rendered in this case.
    #[must_use]
    pub fn stimulus(&self, case: Case) -> Stimulus {
        match (case, self.different) {
            (Case::A, Answer::A) | (Case::B, Answer::B) => self.comparison,
            _ => self.reference,
        }
    }
}

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
    /// From the beginning. A plan without an order gets the one of its seed.
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

    /// From where a file ends.
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

    /// What is presented.
    #[must_use]
    pub fn plan(&self) -> &ForcedChoicePlan {
        &self.plan
    }

    /// Trials finished, and at most in all: an adaptive batch may end earlier.
    #[must_use]
    pub fn progress(&self) -> (usize, usize) {
        let left: usize = self.plan.order.iter().skip(self.batch).map(Vec::len).sum();
        (self.done, self.done + left.saturating_sub(self.within))
    }

    /// The question to present; nothing when the session is complete.
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

    /// Which case is felt now.
    #[must_use]
    pub fn case(&self) -> Case {
        self.case
    }

    /// The next case: baseline, A, B, and baseline again.
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

    /// The trial under way is given up and begins anew with its baseline.
    pub fn abandon(&mut self) {
        self.case = Case::Baseline;
        self.visits = [1, 0, 0];
    }

    /// All three were felt.
    #[must_use]
    pub fn may_answer(&self) -> bool {
        self.visits.iter().all(|&count| count > 0)
    }

    /// The subject names a case, `seconds` after the first presentation. Nothing before all three were felt, or when
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

    /// What an adaptive batch knows by now.
    #[must_use]
    pub fn belief(&self) -> Option<Belief> {
        self.quest.as_ref().map(QuestPlus::belief)
    }

    /// A trial is over.
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

    fn right(choice: &mut ForcedChoice) -> ForcedChoiceTrial {
        let different = choice.next().expect("a question").different;
        choice.advance();
        choice.advance();
        choice.answer(different, 1.0).expect("all felt")
    }

    #[test]
    fn thirty_trials_each_level_twice_and_only_one_case_differs() {
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
    fn a_trial_that_was_given_up_went_on_with_the_case_it_was_in() {
        let mut task = ForcedChoice::new(ForcedChoicePlan::thesis(1));
        task.advance();
        task.advance();
        assert!(task.may_answer());
        task.abandon();
        assert!(task.case() == Case::Baseline && !task.may_answer());
        assert!(task.answer(Answer::A, 1.0).is_none());
    }

    #[test]
    fn a_resumed_session_asks_what_it_would_have_asked() {
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
            // through the text of a file
            let text = serde_json::to_string(&records).expect("text");
            let records: Vec<Record> = serde_json::from_str(&text).expect("records");
            let resumed = ForcedChoice::resume(plan, &records);
            assert_eq!(resumed.next(), choice.next());
            assert_eq!(resumed.progress(), choice.progress());
        }
    }

    #[test]
    fn an_experimenter_defines_batches() {
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
