//! The same, different, or undecided.

use serde::Serialize;

/// What the ratio says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The ratio's interval is within the margin
    Same,
    /// The ratio's interval is completely beyond the margin
    Different,
    /// Neither of these
    Undecided,
}

/// *The same* where all are, *different* where one is.
pub(crate) fn all_of(verdicts: &[Verdict]) -> Verdict {
    if verdicts.contains(&Verdict::Different) {
        Verdict::Different
    } else if verdicts.contains(&Verdict::Undecided) {
        Verdict::Undecided
    } else {
        Verdict::Same
    }
}
