//! Plan of a forced choice, and its questions [thesis, ch. 5.3.2].

use crate::batch::{Batch, Procedure};
use crate::stimulus::Stimulus;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Answer of a subject.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Answer {
    /// First comparison.
    A,
    /// Second comparison.
    B,
}

/// Case of a trial.
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
    /// Comparison within its batch, from 1. 0: the procedure chooses.
    pub level: usize,
    /// The case that differs.
    pub different: Answer,
}

/// Plan of a session. Stored completely in the session's file, so that a session resumes as it began.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForcedChoicePlan {
    /// Seed of the order and of the sides.
    #[serde(default)]
    pub seed: u64,
    /// Batches in order.
    #[serde(rename = "batch")]
    pub batches: Vec<Batch>,
    /// Trials of each batch. Drawn from the seed if empty.
    #[serde(default)]
    pub order: Vec<Vec<Planned>>,
}

impl ForcedChoicePlan {
    /// A plan of these batches, in the order of the seed.
    #[must_use]
    pub fn new(seed: u64, batches: Vec<Batch>) -> Self {
        let mut plan = Self { seed, batches, order: Vec::new() };
        plan.order = plan.drawn();
        plan
    }

    /// The printed batches 1 to 3, 30 trials [thesis, ch. 5.3.2].
    #[must_use]
    pub fn thesis(seed: u64) -> Self {
        Self::new(seed, (1..=3).filter_map(Batch::printed).collect())
    }

    /// The same three batches with levels chosen by QUEST+.
    #[must_use]
    pub fn adaptive(seed: u64) -> Self {
        Self::new(seed, (1..=3).filter_map(Batch::adaptive).collect())
    }

    /// User-defined batches from TOML (`[[batch]]` with `name`, `reference` and `procedure`).
    ///
    /// # Errors
    /// The line and what is accepted there, or the first batch that cannot be presented.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let mut plan: Self = toml::from_str(text).map_err(|e| e.to_string().trim().to_owned())?;
        plan.validate()?;
        if plan.order.is_empty() {
            plan.order = plan.drawn();
        }
        Ok(plan)
    }

    /// Order from the seed: each round has every level once in random order; a fair coin decides the side that differs.
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

    /// Checks that everything can be presented.
    ///
    /// # Errors
    /// Batch, parameter, value and accepted range.
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
    /// Name of the batch.
    pub batch: String,
    /// Level within the batch, from 1. 0 if a procedure chose it.
    pub level: usize,
    /// Baseline.
    pub reference: Stimulus,
    /// Levels that differ.
    pub comparison: Stimulus,
    /// Difference, N.
    pub difference_n: f64,
    /// The case that differs. Hidden from the subject.
    pub different: Answer,
}

impl Presentation {
    /// Block rendered in this case.
    #[must_use]
    pub fn stimulus(&self, case: Case) -> Stimulus {
        match (case, self.different) {
            (Case::A, Answer::A) | (Case::B, Answer::B) => self.comparison,
            _ => self.reference,
        }
    }
}
