//! Messages to the pages.

use crate::known::Known;
use crate::plane::{Row, Shown, Work};
use crate::verdict::Verdict;
use serde::Serialize;

/// Tone of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tone {
    /// It was done.
    Done,
    /// It was done, but.
    Warning,
    /// It was not done.
    Refused,
    /// Something broke.
    Error,
    /// Nobody asked.
    News,
}

/// One message to pages.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Say<'a> {
    /// Everything that is known.
    State(&'a Known),
    /// A sentence.
    Said {
        /// How.
        tone: Tone,
        /// About what, one word.
        about: &'a str,
        /// The sentence.
        text: &'a str,
    },
    /// What a proposal would mean; to the page that asked.
    Proposed {
        /// As asked.
        id: u32,
        /// What validation says.
        verdict: Verdict,
    },
    /// The plane of this page: surfaces and task.
    Plane(Shown<'a>),
    /// Every step of the puck since the last message.
    Puck {
        /// The steps.
        rows: &'a [Row],
        /// Energy since the surface was chosen.
        work: Work,
    },
    /// Batches this page was too slow for.
    Skipped {
        /// How many.
        batches: u64,
    },
    /// Answer to a ping.
    Pong {
        /// As asked.
        id: f64,
        /// Clock of the batches, ms.
        clock: u32,
    },
}

impl Say<'_> {
    /// As text.
    #[must_use]
    pub fn to_json(&self) -> String {
        // numbers, strings and lists: nothing of them can fail
        serde_json::to_string(self).unwrap_or_default()
    }
}
