//! What a diagnosis says: the JSON of `tribos diagnose` (schema `tribos.diagnosis/2`) as types.

use crate::experiment::proposal::{Experiment, NextExperiment};
use crate::per_recording::PerRecording;
use serde::Serialize;
use signals::{Preparation, RecordingFault};
use std::collections::BTreeMap;

/// Version of the JSON layout.
pub const SCHEMA: &str = "tribos.diagnosis/2";

/// The answer to "does the simulation miss something here?".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The recording contains physics the baseline does not.
    Mismatch,
    /// Nothing above the noise floor; the bound says what would have been missed.
    NoMismatch,
    /// The recording cannot answer: too short, too little motion, or faulty.
    NotTestable,
}

/// A number with its standard deviation and unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// Estimate.
    pub value: f64,
    /// Standard deviation of the estimate; NaN serialises as null.
    pub std: f64,
    /// SI unit.
    pub unit: String,
}

/// Level below which nothing can be told from the recording's own repeatability.
#[derive(Debug, Clone, Serialize)]
pub struct NoiseFloor {
    /// Root mean square, in `unit`.
    pub rms: f64,
    /// N or N·m.
    pub unit: String,
    /// `repeats`, `local differences` or `declared`.
    pub how: String,
}

/// The model everything is compared with, fitted jointly with its nuisances.
#[derive(Debug, Clone, Serialize)]
pub struct Baseline {
    /// Law id.
    pub law: String,
    /// Parameters by name.
    pub parameters: BTreeMap<String, Quantity>,
    /// Error on blocks not used for the fit.
    pub rms_heldout: f64,
}

/// A stretch of one coordinate in which the residual's conditional mean leaves its simultaneous band, or, for an effect of
/// a motion channel, in which more of the squared error it makes sits than of the samples.
#[derive(Debug, Clone, Serialize)]
pub struct Location {
    /// `velocity`, `position`, `distance_since_reversal`, `time`, …
    pub coordinate: String,
    /// Lower end of the stretch.
    pub from: f64,
    /// Upper end of the stretch.
    pub to: f64,
    /// Unit of `from` and `to`.
    pub unit: String,
    /// Share of the squared error above the noise floor that sits in the stretch.
    pub share_of_mismatch: f64,
    /// Family-wise p value of the coordinate, by block sign flips (max statistic).
    pub p: f64,
}

/// One named piece of physics that was left out.
#[derive(Debug, Clone, Serialize)]
pub struct Missing {
    /// Catalogue id.
    pub effect: String,
    /// One plain sentence.
    pub says: String,
    /// The equation.
    pub equation: String,
    /// Its parameters, fitted jointly with the baseline.
    pub parameters: BTreeMap<String, Quantity>,
    /// Held-out error without it.
    pub rms_heldout_before: f64,
    /// Held-out error with it.
    pub rms_heldout_after: f64,
    /// 95 % block-bootstrap interval of the held-out gain, in the force unit.
    pub gain_ci95: [f64; 2],
    /// p value against the best null term.
    pub p: f64,
    /// Effects that explain this recording equally well.
    pub indistinguishable_from: Vec<String>,
    /// The move that would tell them apart.
    pub experiment: String,
    /// The curve or map of what has no name.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub free_form: Option<FreeFormFinding>,
}

/// What has no name: a free form over one coordinate or two.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FreeFormFinding {
    /// What it depends on.
    pub coordinates: Vec<String>,
    /// Their units.
    pub units: Vec<String>,
    /// Its values.
    pub curve: FreeCurve,
    /// A formula within its band.
    pub looks_like: Option<LooksLike>,
    /// Effects that were named and add nothing beside it.
    pub kin: Vec<String>,
}

/// A formula that a curve looks like. A hint: others may lie within the band, too.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LooksLike {
    /// In the coordinate's name; times `gain`.
    pub formula: String,
    /// Its parameters; `gain` multiplies it.
    pub parameters: BTreeMap<String, Quantity>,
    /// The next best formula.
    pub runner_up: Option<String>,
    /// What in a machine usually makes such a curve.
    pub made_by: String,
}

/// A curve over one coordinate, or a map over two.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FreeCurve {
    /// What multiplies it: `one`, `direction` or `velocity`.
    pub times: String,
    /// Time constant with which what was slid fades, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory_s: Option<f64>,
    /// Time after which it repeats, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// Knots on the first coordinate.
    pub knots: Vec<f64>,
    /// Knots on the second; empty for a curve.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub knots_across: Vec<f64>,
    /// Values at the knots; of a map for each of `knots` at all of `knots_across`.
    pub values: Vec<f64>,
    /// Half-width of the 95 % interval of each value.
    pub band: Vec<f64>,
    /// Unit of the values.
    pub unit: String,
}

/// An effect that was named and does not predict what it was not fitted on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CarriesNot {
    /// Catalogue id.
    pub effect: String,
    /// The regime or the recording where it fails, or the bound that its shape ends on.
    pub regime: String,
    /// Error there without it; NaN (null) where it is withdrawn for a bound.
    pub rms_before: f64,
    /// Error there with it, fitted on the rest.
    pub rms_after: f64,
}

/// Error on what was not fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// The recordings, or the regime of the recording that was left out.
    pub on: String,
    /// Error of the baseline there.
    pub rms_before: f64,
    /// Error there of the model with everything that was named.
    pub rms_after: f64,
}

/// An effect this recording cannot show.
#[derive(Debug, Clone, Serialize)]
pub struct Blind {
    /// Catalogue id.
    pub effect: String,
    /// Why.
    pub because: String,
    /// The move that would show it.
    pub experiment: String,
}

/// An effect that was tested and is not there, with its bound.
#[derive(Debug, Clone, Serialize)]
pub struct Rejected {
    /// Catalogue id.
    pub effect: String,
    /// 95 % upper bound of its rms force over all samples, those around reversals that are set aside included.
    pub upper_bound: f64,
    /// N or N·m.
    pub unit: String,
}

/// The model with everything that was named.
#[derive(Debug, Clone, Serialize)]
pub struct After {
    /// Held-out error.
    pub rms_heldout: f64,
    /// Relative position error of a free-run simulation over the recording, null if it could not be run.
    pub free_run_error: Option<f64>,
    /// Share of the baseline's mismatch above the noise floor that is now explained.
    pub explained_share: f64,
    /// The baseline's parameters as fitted jointly with everything that was named.
    pub parameters: BTreeMap<String, Quantity>,
}

/// A recording that was not used for the fit, judged with structure and parameters frozen.
#[derive(Debug, Clone, Serialize)]
pub struct Validation {
    /// Name of the recording.
    pub recording: String,
    /// Error of the frozen baseline.
    pub rms_before: f64,
    /// Error of the frozen model with everything that was named.
    pub rms_after: f64,
    /// The same over the root mean square of the force.
    pub relative_before: f64,
    /// The same over the root mean square of the force.
    pub relative_after: f64,
    /// Nuisances that were fitted again for the figures below; the figures above are frozen in any case.
    pub refitted: Vec<String>,
    /// Error of the baseline with its declared nuisances fitted again; None when none was declared.
    pub rms_before_refitted: Option<f64>,
    /// The same of the model with everything that was named.
    pub rms_after_refitted: Option<f64>,
    /// The same over the root mean square of the force.
    pub relative_before_refitted: Option<f64>,
    /// The same over the root mean square of the force.
    pub relative_after_refitted: Option<f64>,
    /// What they came out as, with everything that was named.
    pub nuisances: Vec<PerRecording>,
}

/// What is left, and where.
#[derive(Debug, Clone, Serialize)]
pub struct Remainder {
    /// Root mean square of the unexplained part, noise floor removed.
    pub rms: f64,
    /// Where it still leaves the band.
    pub located_at: Vec<Location>,
}

/// One bin of a conditional mean, for the report.
#[derive(Debug, Clone, Copy, Default)]
pub struct Bin {
    /// Centre of the bin on its coordinate.
    pub at: f64,
    /// Mean residual before any effect is added.
    pub before: f64,
    /// Mean residual after.
    pub after: f64,
    /// Half-width of the simultaneous 95 % band.
    pub band: f64,
}

/// A conditional-mean curve over one coordinate.
#[derive(Debug, Clone, Default)]
pub struct Curve {
    /// Coordinate name, as in [`Location`].
    pub coordinate: String,
    /// Unit of the coordinate.
    pub unit: String,
    /// Sub-set, e.g. `moving forward`; empty for all.
    pub subset: String,
    /// Bins in order.
    pub bins: Vec<Bin>,
}

/// Series for the report's pictures; equal lengths.
#[derive(Debug, Clone, Default)]
pub struct Figures {
    /// Time, s.
    pub time: Vec<f64>,
    /// Position, m or rad.
    pub position: Vec<f64>,
    /// Velocity.
    pub velocity: Vec<f64>,
    /// Measured (filtered) force.
    pub force: Vec<f64>,
    /// Baseline prediction, each sample predicted by a fit that did not see its block.
    pub before: Vec<f64>,
    /// The same with the named effects.
    pub after: Vec<f64>,
    /// Free-run simulated position with the final model, empty if not run.
    pub free_run_position: Vec<f64>,
    /// Conditional means, most telling first.
    pub curves: Vec<Curve>,
}

/// Held-out error over the noise floor up to which the model explains a recording down to its noise. The floor is known to
/// some tens of percent.
const DOWN_TO: f64 = 1.5;

/// Everything a diagnosis found.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// [`SCHEMA`].
    pub schema: &'static str,
    /// The answer.
    pub verdict: Verdict,
    /// The answer as one sentence for a person.
    pub summary: String,
    /// Faults of the recording, which are not physics.
    pub recording_faults: Vec<RecordingFault>,
    /// What was done to each recording before anything was fitted. Of the faults, those that only the fit could see are
    /// not in it.
    pub preparation: Vec<Preparation>,
    /// Repeatability.
    pub noise_floor: NoiseFloor,
    /// The model without the missing physics.
    pub baseline: Baseline,
    /// Where it goes wrong, most telling first.
    pub location: Vec<Location>,
    /// What is missing, by held-out gain.
    pub missing: Vec<Missing>,
    /// Faults of a channel that were repaired before anything was fitted: no physics that a simulation must contain.
    pub instruments: Vec<Missing>,
    /// What was named and withdrawn, because it does not hold where it was not fitted.
    pub does_not_carry_over: Vec<CarriesNot>,
    /// Error on what was not fitted: recordings given to judge, or the regime left out in which the model does worst.
    pub left_out: Option<LeftOut>,
    /// What cannot be seen here.
    pub blind_to: Vec<Blind>,
    /// What was ruled out.
    pub rejected: Vec<Rejected>,
    /// The model with what was found.
    pub after: After,
    /// What is left.
    pub remainder: Remainder,
    /// Root-mean-square force above which a typical effect would have been seen, in the force unit.
    pub detectable: f64,
    /// Share of the samples that were judged: those at which the body slides and the direction is known. At rest friction
    /// is whatever balances the applied force, and says nothing.
    pub judged_share: f64,
    /// Share of the samples that was fitted: of a recording with more than about 100 000, evenly spread parts.
    pub fitted_share: f64,
    /// Cut-off of the one zero-phase filter, Hz; every error above is behind it.
    pub cutoff_hz: f64,
    /// Nuisances that were declared to differ between the recordings fitted, relative to the first.
    pub nuisances: Vec<PerRecording>,
    /// Recordings not used for the fit.
    pub validation: Vec<Validation>,
    /// The best move for each open question: rivals of what is missing first, then what could not be seen.
    pub experiments: Vec<Experiment>,
    /// The one move that answers most of them; None when nothing a move could answer is open.
    pub next_experiment: Option<NextExperiment>,
    /// The final model: `model.toml`, a preset.
    #[serde(skip)]
    pub model: Option<identify::Model>,
    /// For the report.
    #[serde(skip)]
    pub figures: Figures,
}

impl Diagnosis {
    /// Whether the baseline alone explains the recording down to its noise.
    #[must_use]
    pub fn is_down_to_its_noise(&self) -> bool {
        !(self.baseline.rms_heldout > DOWN_TO * self.noise_floor.rms)
    }
}
