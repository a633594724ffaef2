//! Two boards, one trait.

#[cfg(target_os = "none")]
#[allow(unsafe_code)] // registers; the only place
pub mod nucleo_g474re;
#[cfg(not(target_os = "none"))]
pub mod simulated;

use crate::app::Earlier;
use crate::presets::NotStored;
use core::fmt::Write;
use haptics::Device;
use link::HelpLine;

/// What the tasks ask of a board.
pub trait Board {
    /// For people.
    fn name(&self) -> &'static str;

    /// Constants of the device on this board.
    fn device(&self) -> Device;

    /// Time since the start, ms; wraps.
    fn now_ms(&self) -> u32;

    /// Control steps whose force came out late.
    fn late_steps(&self) -> u32;

    /// Begins to store an item of the presets; one at a time.
    fn store(&mut self, key: u8, item: &[u8]);

    /// How that went, once.
    fn stored(&mut self) -> Option<Result<(), NotStored>>;

    /// How long what is stored lasts: “in flash”.
    fn lasting(&self) -> &str;

    /// The fault that was kept over the last reset, until it is cleared.
    fn earlier(&self) -> Option<Earlier> {
        None
    }

    /// The fault was cleared: the next one is the first again.
    fn forget(&mut self) {}

    /// Commands that only this board has.
    fn help(&self) -> &'static [HelpLine] {
        &[]
    }

    /// Obeys such a command: `None` if the line is none. What it says goes into `out`; in the error is the code.
    fn command(&mut self, _line: &str, _out: &mut dyn Write) -> Option<Result<(), &'static str>> {
        None
    }
}
