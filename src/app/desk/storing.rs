//! Items that the board is storing, with the answers that wait for them.

use crate::app::line::Line;
use crate::board::Board;
use crate::presets::NotStored;
use link::{Change, Name};

/// Longest time for the board to store an item, ms. It erases at most two pages.
const PATIENCE_MS: u32 = 2_000;

/// A change of the presets that is being stored.
pub(super) struct Saving {
    pub change: Change,
    pub name: Name,
    pub done: Done,
    /// Time at which the board got it, ms.
    pub since: u32,
}

/// Answer once the change is stored.
#[derive(Clone, Copy)]
pub(super) enum Done {
    Saved,
    Deleted,
    Default,
    /// No answer.
    Repaired,
}

/// A calibration, or an origin, that is in use and being stored.
pub(super) struct Keeping {
    pub answer: Line,
    /// It is a message, to no command.
    pub unasked: bool,
    /// Time at which the board got it, ms.
    pub since: Option<u32>,
}

/// Result of the store that began at `since`, once there is one. A board that takes too long has refused.
pub(super) fn outcome(since: u32, board: &mut impl Board) -> Option<Result<(), NotStored>> {
    let stored = board.stored();
    stored.or_else(|| (board.now_ms().wrapping_sub(since) > PATIENCE_MS).then_some(Err(NotStored::Refused)))
}
