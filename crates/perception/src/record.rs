//! Records of a session's file: a header, then one record per finished trial.

use crate::forced_choice_plan::{Answer, ForcedChoicePlan, Presentation};
use crate::ring_plan::{RingCase, RingPlan};
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
    /// Subject.
    pub subject: Subject,
    /// Start of the session in RFC 3339, or empty without a clock.
    #[serde(default)]
    pub began: String,
    /// Device: a port, `sim`, or the model of a simulated subject.
    #[serde(default)]
    pub device: String,
    /// Experiment.
    pub experiment: Experiment,
}

/// Subject of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Subject {
    /// A label, not a person's name.
    pub id: String,
    /// Model that made the data, if no human did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated: Option<Simulated>,
}

/// Model of a simulated subject.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Simulated {
    /// One sentence on the model.
    pub model: String,
    /// Seed of this subject.
    pub seed: u64,
    /// Parameters as name and value in SI.
    pub parameters: Vec<(String, f64)>,
}

/// Experiment of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Experiment {
    /// Targeting task.
    Targeting(TargetingPlan),
    /// Forced choice.
    ForcedChoice(ForcedChoicePlan),
    /// Targeting in the plane.
    Ring(RingPlan),
}

/// One finished trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Record {
    /// Segment of the targeting task.
    Targeting(TargetingTrial),
    /// Answer of the forced choice.
    ForcedChoice(ForcedChoiceTrial),
    /// Circle of targets in the plane.
    Ring(RingTrial),
}

/// A click of the targeting task.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Click {
    /// Time since the segment began, s.
    pub time_s: f64,
    /// Centre of the cursor, pixels from the centre of travel.
    pub position_px: f64,
    /// Centre of the target, pixels.
    pub target_px: f64,
    /// Whether the cursor was completely inside.
    pub valid: bool,
}

/// A finished segment of the targeting task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TargetingTrial {
    /// Number of the segment from 1, practice included.
    pub number: usize,
    /// Whether the segment is practice, which is not analysed.
    pub practice: bool,
    /// Resistance.
    pub resistance: Resistance,
    /// Targets.
    pub difficulty: Difficulty,
    /// Index of difficulty, bits.
    pub id_bits: f64,
    /// Handle travel of a pixel, m.
    pub metre_per_px: f64,
    /// Time from the appearance of the targets to the eighth valid click, s.
    pub completion_s: f64,
    /// Number of clicks that missed.
    pub errors: usize,
    /// Mean distance of missed clicks from the rim, mm of handle travel. 0 without errors.
    pub mean_error_mm: f64,
    /// All clicks.
    pub clicks: Vec<Click>,
    /// File of the 1 kHz trajectory, in the folder of the session's file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trajectory: Option<String>,
}

impl TargetingTrial {
    /// The record of a segment with these clicks.
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

/// One answered question of the forced choice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ForcedChoiceTrial {
    /// Number of the trial from 1.
    pub number: usize,
    /// Name of the batch.
    pub batch: String,
    /// Level within the batch, from 1. 0 if a procedure chose it.
    pub level: usize,
    /// Reference.
    pub reference: Stimulus,
    /// Levels that differ.
    pub comparison: Stimulus,
    /// Difference, N. Always positive.
    pub difference_n: f64,
    /// The case that differed.
    pub different: Answer,
    /// The case that the subject named.
    pub answer: Answer,
    /// Whether the answer is correct.
    pub correct: bool,
    /// Time from the first presentation to the answer, s.
    pub seconds: f64,
    /// Number of presentations of baseline, A and B.
    pub visits: [u32; 3],
    /// File of the 1 kHz trajectory, in the folder of the session's file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trajectory: Option<String>,
}

impl ForcedChoiceTrial {
    /// The record of a question and its answer.
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

/// A selection of the targeting task in the plane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RingClick {
    /// Time since the first target was hit, s.
    pub time_s: f64,
    /// m from the centre of the circle.
    pub x_m: f64,
    /// m from the centre of the circle.
    pub y_m: f64,
    /// Centre of the target, m.
    pub target_x_m: f64,
    /// Centre of the target, m.
    pub target_y_m: f64,
    /// Whether it was inside.
    pub hit: bool,
}

/// A finished circle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RingTrial {
    /// Number of the circle from 1.
    pub number: usize,
    /// Circle and surface.
    #[serde(flatten)]
    pub case: RingCase,
    /// Index of difficulty, bits.
    pub id_bits: f64,
    /// Number of selections that missed.
    pub errors: usize,
    /// Time from the first target to the last, s.
    pub completion_s: f64,
    /// Every selection. The first hit its target and begins the time.
    pub clicks: Vec<RingClick>,
}
