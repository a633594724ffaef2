//! A proposed move, and what it is good for.

use crate::experiment::moves::Move;
use serde::Serialize;

/// Discrimination at which two explanations count as separated, in noise floors. More does not help: two moves that
/// each settle one question are worth more than one that settles the same question twice.
pub const ENOUGH: f64 = 6.0;
/// Discrimination below which a move is not worth making.
pub const WORTHWHILE: f64 = 3.0;

/// A move, and what it is good for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Experiment {
    /// The effect that was named, or that could not be seen.
    pub effect: String,
    /// The rival it must be separated from; None if the move only makes the effect visible.
    pub rival: Option<String>,
    /// The command for the serial line.
    pub command: String,
    /// The same, to be read by a program.
    #[serde(rename = "move")]
    pub motion: Move,
    /// Expected distance of the explanations after the move, in noise floors; below 3 it is not worth making.
    pub discrimination: f64,
    /// The same before it, from what is already recorded.
    pub discrimination_now: f64,
    /// Cosine of the two signatures, what both share projected out, on what is already recorded.
    pub cosine_now: f64,
    /// The same with the move.
    pub cosine: f64,
}

impl Experiment {
    /// The command, and what it is good for.
    #[must_use]
    pub fn says(&self) -> String {
        let cosine = format!("cosine {:.3} → {:.3}", self.cosine_now, self.cosine);
        let far = short(self.discrimination);
        match &self.rival {
            _ if self.discrimination < WORTHWHILE => {
                let what = self.rival.as_ref().map_or("shows it", |_| "tells them apart");
                format!(
                    "no move within the limits {what}; nearest is {}, at {far} noise floors",
                    self.command
                )
            }
            Some(rival) => format!("{}: tells it from {rival} by {far} noise floors, {cosine}", self.command),
            None => {
                format!(
                    "{}: as strong as the noise floor it would stand out {far} times, {cosine}",
                    self.command
                )
            }
        }
    }
}

fn short(x: f64) -> String {
    if x >= 10.0 { format!("{x:.0}") } else { format!("{x:.1}") }
}

/// The one move that is best for everything that is open.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NextExperiment {
    /// The command for the serial line.
    pub command: String,
    /// The same, to be read by a program.
    #[serde(rename = "move")]
    pub motion: Move,
    /// What it does for each open question.
    pub answers: Vec<Experiment>,
}
