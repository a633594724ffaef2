//! The middle of the stroke, between the control loop and an encoder that knows more than counts.

use super::{Desk, DeskEnds, Keeping, Line};
use crate::app::answer::Pending;
use crate::board::{Board, Middle, MiddleNews};
use core::fmt::Write;
use haptics::{FaultKind, ModeId, Request};
use link::ORIGIN_KEY;

impl Desk {
    /// Tells the encoder what the loop knows, and the loop and the flash what the encoder answers.
    pub(super) fn follow_middle(&mut self, board: &mut impl Board, ends: &mut DeskEnds<'_>) {
        let Some(outputs) = self.last.map(|t| t.outputs) else { return };
        // the first telemetry that knows a middle may be here before the report that tells it
        let settled = core::mem::replace(&mut self.referenced, outputs.referenced) == outputs.referenced;
        let (now, ready) = if outputs.referenced {
            let stores = self.keeping.is_some() || self.saving.is_some();
            (Middle::At(self.origin), settled && !stores)
        } else if outputs.mode == ModeId::Fault {
            (Middle::InDoubt, true)
        } else {
            (Middle::Unknown, outputs.mode == ModeId::Idle && self.pending.is_none())
        };
        if !ready {
            return;
        }
        match board.middle(now, self.device.encoder_reversed) {
            MiddleNews::None => {}
            MiddleNews::Keep(item) => {
                let mut answer = Line::new();
                let _ = answer.write_str("middle of the stroke kept");
                self.keeping = Some(Keeping { answer, unasked: true, since: Some(board.now_ms()) });
                board.store(ORIGIN_KEY, &item);
            }
            MiddleNews::Is(count) => {
                // no room: the next poll tries again
                if ends.ask.enqueue(Request::Middle(count)).is_ok() {
                    self.pending = Some((Pending::Middle, board.now_ms()));
                }
            }
            MiddleNews::Moved => self.alarm = Some(FaultKind::EncoderJump),
        }
    }
}
