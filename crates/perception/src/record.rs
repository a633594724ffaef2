//! What a session's file holds: a header, then one record a finished trial.

use crate::forced_choice::{ForcedChoicePlan, Presentation};
use crate::stimulus::{Resistance, Stimulus};
use crate::targeting_plan::{Difficulty, Segment, TargetingPlan};
use serde::{Deserialize, Serialize};

/// Name of the format, in every header.
pub const SCHEMA: &str = "tribos.session/1";

/// First line of a session's file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// [`SCHEMA`].
    pub schema: String,
    /// Who, or what.
    pub subject: Subject,
    /// When it began: RFC 3339, or empty where there is no clock.
    #[serde(default)]
    pub began: String,
    /// What was felt on: a port, `sim`, the model of a simulated subject.
    #[serde(default)]
    pub device: String,
    /// What is presented.
    pub experiment: Experiment,
}

/// Who answered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Subject {
    /// A label, not a person's name.
    pub id: String,
    /// A model made the data; no human did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated: Option<Simulated>,
}

/// What made the data of a subject that does not exist.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Simulated {
    /// One sentence on the model.
    pub model: String,
    /// Seed of this subject.
    pub seed: u64,
    /// Its parameters, as name and value in SI.
    pub parameters: Vec<(String, f64)>,
}

/// What is presented.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Experiment {
    /// The Fitts task.
    Targeting(TargetingPlan),
    /// Which of two differs?
    ForcedChoice(ForcedChoicePlan),
}

/// One finished trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Record {
    /// Eight valid clicks.
    Targeting(TargetingTrial),
    /// One answer.
    ForcedChoice(ForcedChoiceTrial),
}

/// A click of the targeting task.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Click {
    /// Since the segment began, s.
    pub time_s: f64,
    /// Centre of the cursor from the centre of travel, pixels.
    pub position_px: f64,
    /// Centre of the target that was to be hit, pixels.
    pub target_px: f64,
    /// The cursor was completely inside.
    pub valid: bool,
}

/// A finished segment of the targeting task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TargetingTrial {
    /// From 1, practice included.
    pub number: usize,
    /// Not to be analysed.
    pub practice: bool,
    /// What resisted.
    pub resistance: Resistance,
    /// The targets.
    pub difficulty: Difficulty,
    /// Index of difficulty, bits.
    pub id_bits: f64,
    /// Handle travel of a pixel, m.
    pub metre_per_px: f64,
    /// From the appearance of the targets to the eighth valid click, s.
    pub completion_s: f64,
    /// Clicks that missed.
    pub errors: usize,
    /// Mean distance of the clicks that missed from the rim they missed, mm of handle travel; 0 without errors.
    pub mean_error_mm: f64,
    /// All of them.
    pub clicks: Vec<Click>,
    /// File of the 1 kHz trajectory, beside the session's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trajectory: Option<String>,
}

impl TargetingTrial {
    /// From its clicks.
    #[must_use]
    pub fn new(number: usize, segment: Segment, plan: &TargetingPlan, clicks: Vec<Click>) -> Self {
        let half = 0.5 * segment.difficulty.width_px;
        let misses: Vec<f64> = clicks
            .iter()
            .filter(|click| !click.valid)
            .map(|click| ((click.position_px - click.target_px).abs() - half).max(0.0))
            .collect();
        let mean_px = misses.iter().fold(0.0, |sum, px| sum + px) / misses.len().max(1) as f64;
        Self {
            number,
            practice: segment.practice,
            resistance: segment.resistance,
            difficulty: segment.difficulty,
            id_bits: segment.difficulty.bits(),
            metre_per_px: plan.metre_per_px,
            completion_s: clicks.last().map_or(0.0, |click| click.time_s),
            errors: misses.len(),
            mean_error_mm: mean_px * plan.metre_per_px * 1e3,
            clicks,
            trajectory: None,
        }
    }
}

/// Which of the two comparisons.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Answer {
    /// The first.
    A,
    /// The second.
    B,
}

/// One answered question of the forced choice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ForcedChoiceTrial {
    /// From 1.
    pub number: usize,
    /// Name of its batch.
    pub batch: String,
    /// Level within the batch, from 1; 0 when a procedure chose it.
    pub level: usize,
    /// What it is compared with.
    pub reference: Stimulus,
    /// What differs.
    pub comparison: Stimulus,
    /// By how much, N (always positive).
    pub difference_n: f64,
    /// Which case differed.
    pub different: Answer,
    /// Which one the subject named.
    pub answer: Answer,
    /// They are the same.
    pub correct: bool,
    /// From the first presentation to the answer, s.
    pub seconds: f64,
    /// How often baseline, A and B were felt.
    pub visits: [u32; 3],
    /// File of the 1 kHz trajectory, beside the session's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trajectory: Option<String>,
}

impl ForcedChoiceTrial {
    /// From what was presented and what was answered.
    #[must_use]
    pub fn new(shown: &Presentation, answer: Answer, seconds: f64, visits: [u32; 3]) -> Self {
        Self {
            number: shown.number,
            batch: shown.batch.clone(),
            level: shown.level,
            reference: shown.reference,
            comparison: shown.comparison,
            difference_n: shown.difference_n,
            different: shown.different,
            answer,
            correct: answer == shown.different,
            seconds,
            visits,
            trajectory: None,
        }
    }
}
